#include "ugoki/studio/message_id.h"

#include <algorithm>
#include <cstddef>

#include "ugoki/json/json.h"

namespace ugoki::studio {
namespace {

constexpr std::string_view blanks = " \t\r\n";

/// Position after the string whose opening quote is at position `at`.
std::size_t end_of_string(std::string_view text, std::size_t at) {
  for (++at; at < text.size() && text[at] != '"'; ++at)
    if (text[at] == '\\') ++at;
  return std::min(at + 1, text.size());
}

}  // namespace

std::string id_of_invalid_message(std::string_view text) {
  std::string found;
  int depth = 0;
  bool after_field = false;  // true: the next string is the value of a field, not the name of a field
  for (std::size_t at = 0; at < text.size();) {
    const char c = text[at];
    if (c == '{' || c == '[') ++depth;
    if (c == '}' || c == ']') --depth;
    if (c != '"') {
      if (c == ':') after_field = true;
      if (c == ',' || c == '{') after_field = false;
      ++at;
      continue;
    }
    const std::size_t end = end_of_string(text, at);
    const bool is_id = depth == 1 && !after_field && text.substr(at, end - at) == "\"id\"";
    at = end;
    const std::size_t colon = text.find_first_not_of(blanks, at);
    if (!is_id || colon == std::string_view::npos || text[colon] != ':') continue;
    const std::size_t value = text.find_first_not_of(blanks, colon + 1);
    if (value == std::string_view::npos) break;
    at = text[value] == '"' ? end_of_string(text, value) : std::min(text.find_first_of(",}]{[", value), text.size());
    after_field = true;
    const Result<json::Json> id = json::parse_json(text.substr(value, at - value), "id");
    if (!found.empty() || !id || (!id->is_number() && !id->is_string())) return "null";
    found = json::to_text(*id);
  }
  return found.empty() ? "null" : found;
}

}  // namespace ugoki::studio
