#pragma once
// Prepares motion data as a reference for motion control.

#include "ugoki/motion/smooth_motion.h"

namespace ugoki {

/// Returns the motion without joint jumps (jumps.h), with at least 120 frames per second (upsample.h), with standing feet on the floor
/// (feet_on_floor.h), low-pass filtered at 6 Hz, the standard cut-off for human gait (Winter 2009). The joints of hands, which are light
/// and quick, are filtered at 15 Hz. A computed motion (is_computed) has neither noise nor wrong feet, and is only filtered: at 15 Hz, legs
/// with paws like measured ones.
/// @param floor m, height of the floor
[[nodiscard]] SmoothMotion make_reference(const Motion& motion, const Mechanism& mechanism, double floor);

}  // namespace ugoki
