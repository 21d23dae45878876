#pragma once
// The signal LSIs: numbers and vectors, no physics. docs/circuit.md lists them.

#include "ugoki/circuit/library.h"

namespace ugoki::circuit {

/// Adds numbers and maths, vectors, filters, delays, holds, switches, curves, noise, timers, a state machine, and what stands for
/// keyboard, mouse, gamepad and OSC.
void add_signal_lsis(Library& library);

}  // namespace ugoki::circuit
