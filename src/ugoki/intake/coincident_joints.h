#pragma once
// Joints that a body cannot have twice at one place.

#include <span>
#include <string>
#include <vector>

#include "ugoki/body/recognise.h"
#include "ugoki/motion/skeleton.h"

namespace ugoki::intake {

/// Joints that merge_coincident_joints() has removed.
struct CoincidentJoints {
  std::vector<std::string> points;    ///< carried nothing and had no bone
  std::vector<std::string> carriers;  ///< carried one joint at their own place, which now has their movement

  [[nodiscard]] bool empty() const { return points.empty() && carriers.empty(); }
};

/// Removes joints of a body that have no bone: joints at the place of their parent that carry nothing, and then joints that turn and carry
/// only one joint that is at their place and turns too. Two such joints in a row could turn against each other without moving anything, so
/// that dynamics would accelerate them without bound. The other joints keep their world poses to within a five-hundredth of the skeleton's
/// extent.
/// @param motions all on the skeleton of the character, whose sections of limbs are never removed
CoincidentJoints merge_coincident_joints(std::span<MeasuredMotion> motions, const body::Character& character);

}  // namespace ugoki::intake
