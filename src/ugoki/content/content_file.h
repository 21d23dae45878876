#pragma once
// Content as one JSON text: a scenario document with the mechanisms to which it refers, for example the files in examples/content.

#include <string_view>

#include "ugoki/base/result.h"
#include "ugoki/content/generate.h"

namespace ugoki::content {

struct ContentText {
  Scenario scenario;
  Resources resources;
};

/// Reads {"scenario": {...}, "mechanisms": {ID: {...}}, "circuit": {...}}. docs/scenario.md, docs/formats.md and docs/circuit.md describe
/// the three parts; `circuit` is optional. Other fields are ignored. @param name name of the text in errors, for example its file
[[nodiscard]] Result<ContentText> read_content(std::string_view text, std::string_view name);

}  // namespace ugoki::content
