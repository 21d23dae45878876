#pragma once
// Anchor of balance control: the displacement of the reference.

#include "ugoki/control/balance_model.h"
#include "ugoki/control/ground_support.h"

namespace ugoki::control {

/// Keeps the standing foot of the reference at the standing foot of the character, and its ground at the height of the real ground.
class ReferenceAnchor {
 public:
  /// Updates the displacement in `state`. During double support it moves from the rear to the front foot.
  /// @param support after collect() @param dt s
  void update(const BalanceModel& model, const GroundSupport& support, double dt, BalanceState& state);
  /// m/s: horizontal velocity of the displacement in double support.
  [[nodiscard]] const Vec3& rate() const { return rate_; }
  /// m/s: vertical velocity of the displacement.
  [[nodiscard]] double climb() const { return climb_; }
  /// s: remaining time of the double support.
  [[nodiscard]] double rest() const { return rest_; }

 private:
  Vec3 rate_;
  double rest_ = 0, climb_ = 0;
};

}  // namespace ugoki::control
