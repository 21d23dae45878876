#pragma once
// The feet of a mechanism of any kind: what stands on the ground, and the joints that move it.

#include <span>
#include <string>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/motion/contact_labels.h"

namespace ugoki::motion_edit {

/// A foot with its toes (or a paw, a hoof, the end of a robot's leg) and the limb that carries it.
struct FootLimb {
  int link = -1;                  ///< the foot: the first link of the limb that bears
  std::vector<int> parts;         ///< links that bear: the foot and those behind it
  std::vector<LinkPoint> points;  ///< of all parts
  std::vector<int> heel, toe;     ///< indices of points at the back and at the front; both name all points where the foot is short
  std::vector<int> chain;         ///< links from the limb's base (a joint that moves) to the foot, whose joints move this foot alone
  double length = 0;              ///< m, along the limb's joints from the base to the foot's own joint: its greatest reach
};

/// Feet of the mechanism: links labelled as such (find_feet), with those behind them; where nothing is labelled, the ends of limbs that
/// are lowest in the neutral position. O(links^2).
[[nodiscard]] std::vector<FootLimb> find_foot_limbs(const Mechanism& mechanism);

/// The feet that start at the named links. Errors: an unknown link; one without shape that collides.
[[nodiscard]] Result<std::vector<FootLimb>> find_foot_limbs(const Mechanism& mechanism, std::span<const std::string> links);

/// Mean reach of the limbs [m], to which heights and speeds of contacts are scaled; 0 without limbs.
[[nodiscard]] double mean_leg_length(std::span<const FootLimb> feet);

}  // namespace ugoki::motion_edit
