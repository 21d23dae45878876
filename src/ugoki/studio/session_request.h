#pragma once
// A parsed message from a page. Internal to the session.

#include <algorithm>
#include <string>

#include "ugoki/json/json.h"
#include "ugoki/studio/session.h"

namespace ugoki::studio {

/// Prefix of the ids of motions that operations made. Motions with this prefix that no clip uses are kept for undo and redo only, and are
/// not listed.
inline const std::string made_motion_prefix = "e-";

struct Session::Request {
  json::Json json;
  ClientId client = 0;
  std::string reply_to = "null";
  std::string op;

  /// Error: the field `field` is not `wanted`.
  [[nodiscard]] static std::unexpected<Error> invalid_field(const std::string& field, const std::string& wanted) {
    return fail(ErrorCode::syntax, field, "\"" + field + "\" must be " + wanted + ".", "See docs/studio-protocol.md.");
  }
  [[nodiscard]] bool has_number(const char* key) const { return json.contains(key) && json[key].is_number(); }
  [[nodiscard]] bool has_vector(const char* key) const {
    return json.contains(key) && json[key].is_array() && json[key].size() == 3 &&
           std::ranges::all_of(json[key], [](const json::Json& part) { return part.is_number(); });
  }
};

}  // namespace ugoki::studio
