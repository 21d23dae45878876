#pragma once
// Ground ahead of a character: where its next footholds are, how high they are, and how high a foot must swing to reach them.

#include <vector>

#include "ugoki/control/balance_model.h"
#include "ugoki/control/ground_support.h"
#include "ugoki/control/swing_path.h"

namespace ugoki::control {

/// Reads the ground around the character from the map and plans the heights of the body and of the swing feet.
class GroundPlan {
 public:
  explicit GroundPlan(const BalanceModel& model);
  /// Updates the height and the slope of the ground under the character, and the footholds of all swing feet.
  /// @param support after collect() @param dt s
  void update(const BalanceModel& model, const GroundSupport& support, double dt, BalanceState& state);
  /// m/s: vertical velocity with which the reference is displaced, besides the motion along the slope.
  [[nodiscard]] double climb() const { return climb_; }

 private:
  /// A plane fitted to heights of the ground.
  struct Patch {
    double height = 0;        // m, world: at the middle
    double tilt[2] = {0, 0};  // slope along x and y
    double unevenness = 0;    // m: maximum distance of the ground from the plane
  };
  void update_body(const BalanceModel& model, const GroundSupport& support, double dt, BalanceState& state);
  void lower_body(const BalanceModel& model, double dt, BalanceState& state);
  void update_foot(const BalanceModel& model, std::size_t f, double dt, BalanceState& state) const;
  /// m: displacement of a foothold along the foot, to more even ground. @param wanted m: foothold without it @param R orientation of the
  /// foot
  [[nodiscard]] Vec3 choose_move(const BalanceModel& model, const BalanceState& state, std::size_t f, const Vec3& wanted,
                                 const Mat3& R) const;
  /// Ground under a sole. @param R orientation of the foot's link @param margin m: ground ahead of the sole and behind it that counts, too
  [[nodiscard]] Patch under_sole(const BalanceModel& model, const BalanceState& state, std::size_t f, const Vec3& place, const Mat3& R,
                                 double margin = 0) const;

  std::vector<std::array<Vec3, 2>> half_;  // [feet] m, in the frame of the foot: from the middle of the sole to its front, and to its left
  std::vector<Vec3> middle_;               // [feet] m, in the frame of the foot: middle of the sole
  double climb_ = 0;
};

}  // namespace ugoki::control
