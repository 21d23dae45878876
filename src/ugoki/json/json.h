#pragma once
// JSON text from outside, and errors as JSON.

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "ugoki/base/result.h"

namespace ugoki::json {

/// Keeps the order of fields, so that what is written is canonical.
using Json = nlohmann::ordered_json;

/// Brackets of any document of ours nest less deep; the bound keeps every recursion over a document short.
inline constexpr int max_depth = 100;
/// Objects of ours have a few dozen fields at most. Json finds a field by looking through all, so a bound keeps parsing linear.
inline constexpr int max_fields = 1000;
inline constexpr std::size_t usual_max_size = 64u << 20;

/// Parses text: at most `max_size` bytes, at most max_depth levels deep, at most max_fields in an object, valid UTF-8 with or without byte
/// order mark, no field twice in an object; never throws. Errors (place: name:line) say `truncated` where the text ends too early.
[[nodiscard]] Result<Json> parse_json(std::string_view text, std::string_view name, std::size_t max_size = usual_max_size);

/// "an object", "a number" ...: for messages.
[[nodiscard]] std::string_view type_of(const Json& value);

/// Text of a value; what is not UTF-8 in it (an error may quote a file's bytes) is replaced. @param indent -1: one line
[[nodiscard]] std::string to_text(const Json& json, int indent = -1);

/// {"problems": [{"code", "place", "message", "remedy"}]}
[[nodiscard]] Json error_json(const Error& error);

}  // namespace ugoki::json
