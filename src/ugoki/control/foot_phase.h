#pragma once
// Phase of balance control: which feet stand, and how fast the time of the reference runs.

#include "ugoki/control/balance_model.h"
#include "ugoki/control/ground_support.h"

namespace ugoki::control {

/// Updates the states of the feet and the rate of the reference's time. A foot lifts when its counterpart in the reference lifts, and
/// stands when it touches the ground. @param model with the centroid of this tick @param support after collect() @param dt s
void update_phase(const BalanceModel& model, const GroundSupport& support, double dt, BalanceState& state);

}  // namespace ugoki::control
