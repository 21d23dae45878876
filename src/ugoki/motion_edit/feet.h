#pragma once
// The feet of a mechanism and the limbs that carry them.

#include <span>
#include <string>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/motion/contact_labels.h"

namespace ugoki::motion_edit {

/// A foot with its toes (or a paw, a hoof, the end of a robot's leg) and the limb to which it belongs.
struct FootLimb {
  int link = -1;                  ///< the foot: the first link of the limb that can touch the ground
  std::vector<int> parts;         ///< links that can touch the ground: the foot and its descendants
  std::vector<LinkPoint> points;  ///< support points of all parts
  std::vector<int> heel, toe;     ///< indices into `points` of the back and front of the sole; each has all points if the foot is short
  std::vector<int> chain;         ///< links from the limb's base (with a movable joint) to the foot; their joints move no other foot
  double length = 0;              ///< m, sum of the distances between the joints of the chain: the maximum reach
};

/// Finds the feet: links with the label of a foot (find_feet) and their descendants. Without such labels: the lowest ends of limbs in the
/// neutral position. O(links^2).
[[nodiscard]] std::vector<FootLimb> find_foot_limbs(const Mechanism& mechanism);

/// Returns the feet that begin at the named links. Errors: an unknown link; a link without a colliding shape.
[[nodiscard]] Result<std::vector<FootLimb>> find_foot_limbs(const Mechanism& mechanism, std::span<const std::string> links);

/// Mean length of the limbs [m], by which the thresholds of contact detection are scaled; 0 without limbs.
[[nodiscard]] double mean_leg_length(std::span<const FootLimb> feet);

}  // namespace ugoki::motion_edit
