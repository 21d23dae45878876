#pragma once
// The execution circuit that content runs on when its document brings none: data like any other circuit.

#include <string>

#include "ugoki/content/scenario.h"

namespace ugoki::content {

/// JSON text (docs/circuit.md) of the execution circuit for the document's characters: for each that follows a track motion
/// retrieval, interpolation and control; for all of them events, collision, dynamics, status and display.
[[nodiscard]] std::string default_circuit(const Scenario& scenario);

}  // namespace ugoki::content
