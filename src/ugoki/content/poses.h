#pragma once
// Reads, writes and checks the stored poses of a scenario document. Internal to content.

#include <string>

#include "ugoki/content/json_fields.h"
#include "ugoki/content/scenario.h"

namespace ugoki::content {

/// Reads the fields that are present; absent fields keep their value.
void read_pose(Fields& f, ScenarioPose& out);
[[nodiscard]] Json to_json(const ScenarioPose& pose);

/// Adds a problem for each value that is out of its range. Ids and names are checked by check_scenario().
void check_pose(const ScenarioPose& pose, const std::string& location, Error& problems);

}  // namespace ugoki::content
