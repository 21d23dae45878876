#pragma once
// The id of a message that is not valid JSON.

#include <string>
#include <string_view>

namespace ugoki::studio {

/// Returns the value of the field "id", as JSON text for the reply, of a message that json::parse_json() refuses. Returns "null" unless the
/// field occurs exactly once in the outermost object and its value is a number or a string.
[[nodiscard]] std::string id_of_invalid_message(std::string_view text);

}  // namespace ugoki::studio
