#pragma once
// Travel that a motion lacks: standing feet that slide over the ground all the time. Internal to correction.

#include <span>

#include "ugoki/motion/missing_travel.h"
#include "ugoki/motion/motion.h"
#include "ugoki/motion_edit/feet.h"

namespace ugoki::correction {

/// Returns the travel that the whole character lacks so that its standing feet rest: a walk in place lacks its walking speed.
/// O(frames * points)
[[nodiscard]] MissingTravel find_missing_travel(const Mechanism& mechanism, const Motion& motion,
                                                std::span<const motion_edit::FootLimb> feet);

}  // namespace ugoki::correction
