#pragma once
// From motion data to a reference that motion control can follow.

#include "ugoki/motion/smooth_motion.h"

namespace ugoki {

/// The motion with the soles above the floor: in frames where a foot or its toes (find_feet) reach below z = `floor`, the link is turned
/// about its own joint until its lowest point is on the floor, by the smallest change of the joint's coordinates. Measured feet are rigid
/// and noisy, real ones give way; a body of rigid shapes cannot follow them into the ground. A sole that is level but too deep stays level,
/// and points nearly straight below the joint stay as they are: that is the business of the path's height.
/// @param floor m
[[nodiscard]] Motion with_soles_above(const Motion& motion, const Mechanism& mechanism, double floor);

/// with_soles_above(), then smoothed at 6 Hz, the usual cut-off for human gait (Winter 2009); hands, which are light and
/// quick, at 15 Hz.
[[nodiscard]] SmoothMotion make_reference(const Motion& motion, const Mechanism& mechanism, double floor);

}  // namespace ugoki
