#pragma once
// Answers the request `compare` of a page: the poses of a character with an earlier form of one of its clips, and how far the clip has
// changed since. Never changes the project.

#include <string>

#include "ugoki/base/result.h"
#include "ugoki/json/json.h"
#include "ugoki/studio/shown_scenario.h"

namespace ugoki::studio {

/// @param request `character`, `clip` and `before`, the earlier clip in its JSON form; its motion must still be in the project
/// @return JSON fields of the answer, each with a comma before it (docs/studio-protocol.md)
[[nodiscard]] Result<std::string> compare_motion(const ShownScenario& project, const json::Json& request);

}  // namespace ugoki::studio
