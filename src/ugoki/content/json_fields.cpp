#include "ugoki/content/json_fields.h"

namespace ugoki::content {

void Fields::number(std::string_view key, double& value) {
  json::Fields::number(key, value);
  if (value == 0) value = 0;  // replaces -0 by +0
}

void Fields::vec3(std::string_view key, Vec3& value) {
  double x[3];
  if (!numbers(key, x)) return;
  for (double& component : x)
    if (component == 0) component = 0;
  value = {x[0], x[1], x[2]};
}

Json to_json(const Vec3& v) { return Json::array({v.x, v.y, v.z}); }

}  // namespace ugoki::content
