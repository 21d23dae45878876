#pragma once
// Changes of a stored circuit, item by item: what the wiring editor's commands consist of. Internal to content.

#include <string>

#include "ugoki/content/json_fields.h"

namespace ugoki::content {

/// Applies `changes` (docs/scenario.md, circuit.edit) in their order to a circuit of docs/circuit.md. Items are found by what makes
/// them themselves: LSIs and notes by id, pins, parameters and circuits by name, wires by their ends, probes by their pin.
/// What is not named keeps its place and every field. O(items + changes) for each list that is touched.
/// @param path of `changes`, for messages
void apply_circuit_changes(Json& circuit, const Json& changes, const std::string& path, Error& problems);

/// Problems of the circuit's form, none of its meaning: a circuit that does not run yet can be kept.
[[nodiscard]] Error check_circuit_form(const Json& circuit);

}  // namespace ugoki::content
