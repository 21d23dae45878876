#pragma once
// The signal LSIs: numbers and vectors, no physics. docs/circuit.md lists them.

#include "ugoki/circuit/library.h"

namespace ugoki::circuit {

/// Adds constant, clock, add, subtract, multiply, divide, gain, sum, clamp, compare, switch, integrator, low-pass, vector parts and
/// a delay for every pin type.
void add_signal_lsis(Library& library);

}  // namespace ugoki::circuit
