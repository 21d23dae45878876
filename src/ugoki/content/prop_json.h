#pragma once
// JSON form of props. Internal to content.

#include "ugoki/content/json_fields.h"
#include "ugoki/content/prop.h"

namespace ugoki::content {

/// Reads the fields of the JSON form; absent fields keep their values.
void read_prop(Fields& f, Prop& out);
[[nodiscard]] Json to_json(const Prop& prop);

}  // namespace ugoki::content
