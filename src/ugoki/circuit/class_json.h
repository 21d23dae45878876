#pragma once
// Declarations of LSIs as JSON: for editors, documentation, and the manifests of installed libraries.

#include <string>

#include "ugoki/circuit/library.h"
#include "ugoki/json/json.h"

namespace ugoki::circuit {

/// {"name", "doc", "group", "from", "version", "inputs", "outputs", "parameters", "fields", "state_bytes"}
[[nodiscard]] json::Json class_json(const LsiClass& c);
/// Everything but the functions. Problems have their path behind `place`.
[[nodiscard]] LsiClass read_class(const json::Json& json, const std::string& place, Error& problems);

/// {"pin_types": [...], "classes": [...]}: all that an editor must know.
[[nodiscard]] json::Json library_json(const Library& library);

}  // namespace ugoki::circuit
