#pragma once
// The signal LSIs: operations on numbers and vectors, without physics. docs/circuit.md lists them.

#include "ugoki/circuit/library.h"

namespace ugoki::circuit {

/// Adds the LSIs for numbers, vectors, filters, delays, holds, switches, curves, noise, timers and state machines, and the device LSIs
/// keyboard, mouse, gamepad and OSC (Open Sound Control).
void add_signal_lsis(Library& library);

}  // namespace ugoki::circuit
