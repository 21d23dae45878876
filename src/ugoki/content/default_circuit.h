#pragma once
// The default execution circuit, which runs the content if the document has no circuit of its own. It is data like any other circuit.

#include <string>

#include "ugoki/content/scenario.h"

namespace ugoki::content {

/// Returns the JSON text (docs/circuit.md) of the default execution circuit for the document's characters. Each character that follows a
/// track has LSIs (function blocks) for motion retrieval, interpolation and control. All characters share the LSIs for events, collision,
/// dynamics, status and display.
[[nodiscard]] std::string default_circuit(const Scenario& scenario);

}  // namespace ugoki::content
