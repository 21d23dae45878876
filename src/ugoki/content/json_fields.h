#pragma once
// Fields of the scenario document and of commands. Internal to content and project.

#include <string_view>

#include "ugoki/json/fields.h"
#include "ugoki/spatial/vec3.h"

namespace ugoki::content {

using json::Json;
using json::parse_json;
using json::to_text;
using json::type_of;

/// Numbers have no negative zero, so that equal documents have equal text.
class Fields : public json::Fields {
 public:
  using json::Fields::Fields;

  void number(std::string_view key, double& value);
  void vec3(std::string_view key, Vec3& value);
};

[[nodiscard]] Json to_json(const Vec3& v);

}  // namespace ugoki::content
