#pragma once
// The id of a message that is not valid JSON.

#include <string>
#include <string_view>

namespace ugoki::studio {

/// JSON text of the field "id" of a message that json::parse_json() refuses, for the reply. The field is read if it occurs once in the
/// outermost object and is a number or a string; else the result is "null".
[[nodiscard]] std::string id_of_invalid_message(std::string_view text);

}  // namespace ugoki::studio
