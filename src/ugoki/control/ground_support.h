#pragma once
// Contact of the feet with the ground: which points bear load, how many points of each foot touch, and the support area.

#include <vector>

#include "ugoki/control/balance_model.h"

namespace ugoki::control {

/// A contact point of a foot with the ground, or with another mechanism below the foot.
struct FootContact {
  int foot, link;
  Vec3 p, n;  // m, world: position; unit, world: normal, upwards
  double friction;
  double distance;  // m
  bool loose;       // the other body is not in the map of the ground
};

/// A contact point that bears load.
struct BearingPoint {
  int foot, link;
  Vec3 p, n;  // m, world: position; unit, world: normal
  double friction;
  double height, rise;  // m, m/s: height and upward speed of this material point in the reference
  Vec3 slide;           // m/s, world: wanted velocity; zero, unless the reference turns on this foot
};

/// A point of a standing sole that is above the ground, although the reference has it on the ground.
struct HoveringPoint {
  int foot, link;
  Vec3 p;         // m, world
  double gap;     // m: height above the ground
  double raised;  // m: height in the reference above the lowest point of the sole
};

/// How uneven the ground of the last steps is, from 0 (level) to 1.
double unevenness(const BalanceModel& model, const BalanceState& state);

/// Contacts of one tick, seen as support of a character.
class GroundSupport {
 public:
  explicit GroundSupport(const BalanceModel& model);
  /// Maximum number of contact points of the feet; further contacts are ignored.
  static constexpr std::size_t max_bearing = 64;

  /// Collects the contacts of the feet with surfaces below them: the ground and other mechanisms, for example boxes.
  void collect(const BalanceModel& model, const BalanceInput& input);
  [[nodiscard]] const std::vector<FootContact>& contacts() const { return contacts_; }
  /// Number of contact points of a foot that touch.
  [[nodiscard]] int touching(std::size_t foot) const { return touching_[foot]; }
  /// True if a foot touches anything, a riser too.
  [[nodiscard]] bool blocked(std::size_t foot) const { return blocked_[foot] != 0; }
  /// Ground under the sole of a foot.
  struct Ground {
    bool found = false;  // false: the foot has no contact
    double height = 0;   // m, world: at the centre of the sole
    Vec3 normal{0, 0, 1};
    bool loose = false;  // true: the foot stands on a body that is not in the map of the ground
  };
  [[nodiscard]] Ground ground_under(const BalanceModel& model, std::size_t foot) const;
  /// Finds the points that bear load: close to the ground, on a foot that stands, and not lifted by the reference.
  /// @param pressure m, world: wanted centre of pressure of the character, horizontal
  void find_bearing(const BalanceModel& model, const BalanceState& state, const Vec3& pressure);
  [[nodiscard]] const std::vector<BearingPoint>& bearing() const { return bearing_; }
  /// Points that the controller presses to the ground: the foot tips over an edge until its whole sole bears load.
  [[nodiscard]] const std::vector<HoveringPoint>& hovering() const { return hovering_; }

  /// Computes the distance of p from the edge of the support: the convex hull, in the horizontal plane, of the contact points of a foot
  /// (-1: of all standing feet). @param closest [out] closest point of the hull @return m: signed distance, positive inside; -1000 if no
  /// foot stands
  double distance_to_edge(int foot, const BalanceState& state, const Vec3& p, Vec3& closest);

 private:
  /// Sets the wanted velocities of the points of a foot that turns about a vertical axis.
  void find_turn(const BalanceModel& model, std::size_t foot);

  /// Finds the hovering points of a standing foot, and removes its bearing points that are not at the edge over which it has to tip.
  void find_hovering(const BalanceModel& model, const BalanceState& state, const Vec3& pressure, std::size_t foot);

  /// True if an axis of the foot's own joint is parallel to `axis` (unit) or encloses an angle with it whose cosine is above `cosine`.
  [[nodiscard]] static bool tips_about(const BalanceModel& model, std::size_t foot, const Vec3& axis, double cosine);

  static constexpr double min_rise = 0.5;      // minimum z of a normal: a surface steeper than 60 degrees does not support a foot
  static constexpr double near_ground = 0.01;  // m: points closer than this span the support area

  std::vector<FootContact> contacts_;
  std::vector<BearingPoint> bearing_;
  std::vector<HoveringPoint> hovering_;
  std::vector<int> touching_;           // [feet]
  std::vector<unsigned char> blocked_;  // [feet]
  std::vector<Vec3> hull_;              // scratch
};

}  // namespace ugoki::control
