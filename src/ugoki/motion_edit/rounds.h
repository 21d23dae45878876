#pragma once
// A cyclic motion over several rounds, so that what looks around a frame need not know of the seam.

#include "ugoki/motion/clip.h"

namespace ugoki::motion_edit {

/// Frames of one round of a cyclic motion; its last frame is the first of the next round.
[[nodiscard]] inline int round_frames(const Motion& motion) { return motion.frames - 1; }

/// Three rounds one after the other, the middle one where the motion is; contacts repeated. Not cyclic. At least 2 frames.
[[nodiscard]] Motion three_rounds(const Motion& motion, const Mechanism& mechanism);

/// The middle one of three rounds; its last frame is made its first frame, moved by `cycle`, exactly.
[[nodiscard]] Motion middle_round(const Motion& rounds, const Mechanism& mechanism, const Placement& cycle);

}  // namespace ugoki::motion_edit
