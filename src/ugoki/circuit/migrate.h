#pragma once
// Conversion of circuits of earlier versions to the present format.

#include <span>

#include "ugoki/json/json.h"

namespace ugoki::circuit {

/// Converts the JSON of a circuit of one version to the next version. It accepts any JSON: a part without the expected form is left
/// unchanged, so that the reader can report it with its path.
using Migration = void (*)(json::Json& circuit);

/// All migrations: item k converts version k + 1 to version k + 2. To change the format of circuits, increase circuit_version, add the
/// migration here, and keep a file of the former version in tests/circuit/versions.
[[nodiscard]] std::span<const Migration> migrations();

/// Applies `steps` from `version` (at least 1) to the last one, and sets the field "version".
void migrate(json::Json& circuit, std::int64_t version, std::span<const Migration> steps);

/// Converts a circuit of an earlier version to circuit_version; any other JSON is left unchanged.
void migrate(json::Json& circuit);

}  // namespace ugoki::circuit
