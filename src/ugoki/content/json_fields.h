#pragma once
// Reader for the fields of scenario documents and commands. Internal to content and project.

#include <string_view>

#include "ugoki/json/fields.h"
#include "ugoki/spatial/vec3.h"

namespace ugoki::content {

using json::Json;
using json::parse_json;
using json::to_text;
using json::type_of;

/// Like json::Fields, but replaces negative zero by zero, so that equal documents have equal text.
class Fields : public json::Fields {
 public:
  using json::Fields::Fields;

  void number(std::string_view key, double& value);
  /// Reads a list of three numbers.
  void vec3(std::string_view key, Vec3& value);
};

[[nodiscard]] Json to_json(const Vec3& v);

}  // namespace ugoki::content
