#pragma once
// From motion data to a reference that motion control can follow.

#include "ugoki/motion/smooth_motion.h"

namespace ugoki {

/// The motion without jumps of single joints (jumps.h), with standing feet on the floor (feet_on_floor.h), smoothed at 6 Hz, the usual
/// cut-off for human gait (Winter 2009); hands, which are light and quick, at 15 Hz. @param floor m
[[nodiscard]] SmoothMotion make_reference(const Motion& motion, const Mechanism& mechanism, double floor);

}  // namespace ugoki
