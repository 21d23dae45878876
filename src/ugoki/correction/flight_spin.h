#pragma once
// Constant angular momentum in flights. Internal to correction.

#include "ugoki/correction/observe.h"

namespace ugoki::correction {

/// Turns the whole character about its centre of mass in flights so that its angular momentum is constant. The turn is zero at take-off and
/// at landing, which determines the momentum.
void keep_spin(const Mechanism& m, const Observation& o, Motion& motion);

}  // namespace ugoki::correction
