#pragma once
// Changes items of a stored circuit one by one. The command `circuit.edit` consists of such changes. Internal to content.

#include <string>

#include "ugoki/content/json_fields.h"

namespace ugoki::content {

/// Applies `changes` (docs/scenario.md, circuit.edit) in order to a circuit in the form of docs/circuit.md. Items are found by their key:
/// LSIs (function blocks) and notes by id; pins, parameters and inner circuits by name; wires by both ends; probes by their pin. Items that
/// no change names keep their position and all fields. O(items + changes) for each changed list.
/// After a problem, the circuit may be partly changed. @param path JSON path of `changes`, for messages
void apply_circuit_changes(Json& circuit, const Json& changes, const std::string& path, Error& problems);

/// Returns the problems of the circuit's JSON form. Does not check whether the circuit can be built and run, because unfinished circuits
/// are stored too.
[[nodiscard]] Error check_circuit_form(const Json& circuit);

}  // namespace ugoki::content
