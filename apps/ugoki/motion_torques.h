#pragma once
// `ugoki motion torques` and `ugoki motion angles`: conversions between torque-oriented and angle-oriented motion data.

#include "verb.h"

namespace ugoki::cli {

/// Adds both operations to the verb `motion`.
void add_torque_operations(Verb motion, Action& action);

}  // namespace ugoki::cli
