#pragma once
// Steps of balance control: where the next feet land, and when a character that stands begins a step.

#include "ugoki/control/balance_model.h"
#include "ugoki/control/ground_support.h"

namespace ugoki::control {

/// Plans the steps of a character.
class StepPlanner {
 public:
  /// Starts a reaction step if the reference stands and the DCM has left the support.
  void start_reaction(const BalanceModel& model, GroundSupport& support, double dt, BalanceState& state);
  /// Updates the shifts of the next touch-downs. @param dcm_error m, world: DCM minus its reference
  /// @return m, world, horizontal: error of the DCM at which the feet would land at their even footholds without a further shift
  Vec3 update_shifts(const BalanceModel& model, GroundSupport& support, double dt, const Vec3& dcm_error, BalanceState& state);
};

}  // namespace ugoki::control
