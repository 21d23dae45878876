#pragma once
// Circuits that an older program wrote: brought to the present form before they are read. Internal to circuit.

#include <span>

#include "ugoki/json/json.h"

namespace ugoki::circuit {

/// Changes the JSON of a circuit of one version into that of the next. It must take whatever is there: what does not have the form is
/// left alone, for the reader to refuse with its path.
using Migration = void (*)(json::Json& circuit);

/// Item k leads from version k + 1 to version k + 2; there are circuit_version - 1. To change the form: count circuit_version up, add the
/// step here, and keep a file of the old version in tests/circuit/versions.
[[nodiscard]] std::span<const Migration> migrations();

/// Does the steps from `version` (at least 1) on, and sets the field "version".
void migrate(json::Json& circuit, std::int64_t version, std::span<const Migration> steps);

}  // namespace ugoki::circuit
