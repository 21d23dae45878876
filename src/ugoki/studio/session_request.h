#pragma once
// A message from a page, read. Internal to the session.

#include <algorithm>
#include <string>

#include "ugoki/json/json.h"
#include "ugoki/studio/session.h"

namespace ugoki::studio {

/// Begins the ids of motions that operations made. Where nothing plays them any more they are kept for redo alone, and listed nowhere.
inline const std::string made_motion_prefix = "e-";

struct Session::Request {
  json::Json json;
  ClientId client = 0;
  std::string reply_to = "null";
  std::string op;

  /// A field's problem.
  [[nodiscard]] static std::unexpected<Error> wrong(const std::string& field, const std::string& wanted) {
    return fail(ErrorCode::syntax, field, "\"" + field + "\" must be " + wanted + ".", "See docs/studio-protocol.md.");
  }
  [[nodiscard]] bool has_number(const char* key) const { return json.contains(key) && json[key].is_number(); }
  [[nodiscard]] bool has_vector(const char* key) const {
    return json.contains(key) && json[key].is_array() && json[key].size() == 3 &&
           std::ranges::all_of(json[key], [](const json::Json& part) { return part.is_number(); });
  }
};

}  // namespace ugoki::studio
