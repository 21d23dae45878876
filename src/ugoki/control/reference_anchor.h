#pragma once
// Anchor of balance control: the displacement of the reference.

#include "ugoki/control/balance_model.h"

namespace ugoki::control {

/// Keeps the standing foot of the reference at the standing foot of the character.
class ReferenceAnchor {
 public:
  /// Updates the displacement in `state`. During double support it moves from the rear to the front foot.
  /// @param dt s
  void update(const BalanceModel& model, double dt, BalanceState& state);
  /// m/s: horizontal velocity of the displacement in double support.
  [[nodiscard]] const Vec3& rate() const { return rate_; }
  /// s: remaining time of the double support.
  [[nodiscard]] double rest() const { return rest_; }

 private:
  static void home(const BalanceModel& model, const BalanceState& state, const Vec3& centre, Vec3& shift, double& turn);

  Vec3 rate_;
  double rest_ = 0;
};

}  // namespace ugoki::control
