#pragma once
// Motions of few frames per second as motions of more frames.

#include "ugoki/motion/motion.h"

namespace ugoki {

/// The same motion with at least `rate` frames per second: every interval between two frames is divided into equal parts, as few as
/// possible, along cubic splines with continuous accelerations (de Boor, A Practical Guide to Splines, 1978). Accelerations are constant in
/// the first and the last interval; a cyclic motion continues beyond its ends. Frames of the motion stay as they are. Contact labels of the
/// new frames are those of the nearest frame. O(frames)
/// @param mechanism the mechanism of the motion  @param rate frames per second; a motion that has as many is returned unchanged
[[nodiscard]] Motion upsampled(const Motion& motion, const Mechanism& mechanism, double rate);

}  // namespace ugoki
