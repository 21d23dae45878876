#pragma once
// Parses JSON text from outside, and writes errors as JSON.

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>

#include "ugoki/base/result.h"

namespace ugoki::json {

/// JSON value that keeps the order of its fields, so that equal documents give equal text.
using Json = nlohmann::ordered_json;

/// Maximum nesting depth of brackets in a document. Valid documents of this project are less deep; the bound limits recursion.
inline constexpr int max_depth = 100;
/// Maximum number of fields of one object. Valid documents have at most a few dozen. Json searches fields linearly, so the bound keeps
/// parsing linear in the text size.
inline constexpr int max_fields = 1000;
/// Default for the maximum size of a JSON text: 64 MiB, in bytes.
inline constexpr std::size_t usual_max_size = 64u << 20;

/// Parses JSON text. Never throws. Limits: `max_size` bytes, max_depth nesting levels, max_fields fields per object; valid UTF-8 with or
/// without byte order mark; no repeated field in an object; no number too large for a double. Errors have the location
/// "name:line:column" (columns count characters from 1); their code is `truncated` if the text ends too early.
[[nodiscard]] Result<Json> parse_json(std::string_view text, std::string_view name, std::size_t max_size = usual_max_size);

/// Type of a value in words, for messages: "an object", "a number" ...
[[nodiscard]] std::string_view type_of(const Json& value);

/// JSON text of a value. Invalid UTF-8 (an error may quote bytes of a file) becomes U+FFFD. @param indent blanks per level; -1: one line
[[nodiscard]] std::string to_text(const Json& json, int indent = -1);

/// The error as JSON: {"problems": [{"code", "location", "message", "remedy"}]}.
[[nodiscard]] Json error_json(const Error& error);

/// Renames the field `former` of an object to `key`, unless the object has `key` already. @param object ordered or unordered JSON object
template <class AnyJson>
void rename_field(AnyJson& object, const char* former, const char* key) {
  if (!object.is_object() || !object.contains(former) || object.contains(key)) return;
  AnyJson value = std::move(object[former]);
  object.erase(former);
  object[key] = std::move(value);
}

}  // namespace ugoki::json
