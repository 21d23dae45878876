#pragma once
// A parsed message from a page. Internal to the session.

#include <algorithm>
#include <string>

#include "ugoki/base/number.h"
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

  // Data of the library that the request needs; Session::library_work() reads them.
  bool read_library = false;                            ///< true after an attempt to read `motion` or `body`
  Result<std::vector<project::LibraryData>> resources;  ///< library data that a command names
  Result<ProjectEntry> motion;                          ///< the second motion of an operation
  Result<ProjectEntry> body;                            ///< the mechanism to retarget to

  /// The error "the field `field` is not `wanted`".
  [[nodiscard]] static std::unexpected<Error> invalid_field(const std::string& field, const std::string& wanted) {
    return fail(ErrorCode::syntax, field, "\"" + field + "\" must be " + wanted + ".", "See docs/studio-protocol.md.");
  }
  /// The error "the number in the field `field` is out of its range".
  [[nodiscard]] static std::unexpected<Error> out_of_range(const std::string& field, double min, double max, const std::string& remedy) {
    return fail(ErrorCode::range, field, "\"" + field + "\" must be from " + to_text(min) + " to " + to_text(max) + ".", remedy);
  }
  [[nodiscard]] bool is_number_from(const char* key, double min, double max) const {
    return has_number(key) && json[key].get<double>() >= min && json[key].get<double>() <= max;
  }
  [[nodiscard]] bool has_number(const char* key) const { return json.contains(key) && json[key].is_number(); }
  /// True if the field is a text that can be a path: not empty, and without the character NUL, at which the system would cut the path off.
  [[nodiscard]] bool has_path(const char* key) const {
    if (!json.contains(key) || !json[key].is_string()) return false;
    const std::string text = json[key].get<std::string>();
    return !text.empty() && text.find('\0') == std::string::npos;
  }
  [[nodiscard]] bool has_vector(const char* key) const {
    return json.contains(key) && json[key].is_array() && json[key].size() == 3 &&
           std::ranges::all_of(json[key], [](const json::Json& part) { return part.is_number(); });
  }
};

}  // namespace ugoki::studio
