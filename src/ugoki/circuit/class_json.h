#pragma once
// JSON form of LSI declarations: for editors, documentation, and the manifests of installed libraries.

#include <string>

#include "ugoki/circuit/library.h"
#include "ugoki/json/json.h"

namespace ugoki::circuit {

/// Returns the declaration as a JSON object
/// {"name", "doc", "group", "from", "version", "inputs", "outputs", "parameters", "fields", "state_bytes"}.
[[nodiscard]] json::Json class_json(const LsiClass& c);
/// Reads the object that class_json writes; the functions of the class stay null. Each problem has its JSON path, which begins with
/// `location`.
[[nodiscard]] LsiClass read_class(const json::Json& json, const std::string& location, Error& problems);

/// Returns all pin types and LSI classes, for an editor: {"pin_types": [...], "classes": [...]}.
[[nodiscard]] json::Json library_json(const Library& library);

}  // namespace ugoki::circuit
