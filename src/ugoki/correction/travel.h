#pragma once
// Travel that a motion lacks: standing feet that slide over the ground all the time. Internal to correction.

#include <span>

#include "ugoki/motion/motion.h"
#include "ugoki/motion_edit/feet.h"

namespace ugoki::correction {

/// Returns the velocity [m/s, horizontal] that the whole character lacks so that its standing feet rest: a walk in place lacks its walking
/// speed. Zero if the lowest feet rest, or move over the ground without a common velocity. O(frames * points)
[[nodiscard]] Vec3 find_missing_travel(const Mechanism& mechanism, const Motion& motion, std::span<const motion_edit::FootLimb> feet);

}  // namespace ugoki::correction
