#pragma once
// Contact of the feet with the ground: which points bear load, how many points of each foot touch, and the support area.

#include <vector>

#include "ugoki/control/balance_model.h"

namespace ugoki::control {

/// A contact point that bears load.
struct BearingPoint {
  int foot, link;
  Vec3 p, n;  // m, world: position; unit, world: normal
  double friction;
  double height, rise;  // m, m/s: height and upward speed of this material point in the reference
};

/// Contacts of one tick, seen as support of a character.
class GroundSupport {
 public:
  explicit GroundSupport(const BalanceModel& model);
  /// Maximum number of points that bear load.
  static constexpr std::size_t max_bearing = 64;

  /// Counts the contacts of each foot.
  void count_contacts(const BalanceModel& model, const BalanceInput& input);
  /// Number of contacts of a foot, from count_contacts().
  [[nodiscard]] int touching(std::size_t foot) const { return touching_[foot]; }
  /// Finds the points that bear load: close to the ground, on a foot that stands, and not lifted by the reference.
  void find_bearing(const BalanceModel& model, const BalanceInput& input, const BalanceState& state);
  [[nodiscard]] const std::vector<BearingPoint>& bearing() const { return bearing_; }

  /// Computes the distance of p from the edge of the support: the convex hull, in the horizontal plane, of the contact points of a foot
  /// (-1: of all standing feet). @param closest [out] closest point of the hull @return m: signed distance, positive inside; -1000 if no
  /// foot stands
  double distance_to_edge(const BalanceModel& model, int foot, const BalanceInput& input, const BalanceState& state, const Vec3& p,
                          Vec3& closest);

 private:
  std::vector<BearingPoint> bearing_;
  std::vector<int> touching_;  // [feet]
  std::vector<Vec3> hull_;     // scratch
};

}  // namespace ugoki::control
