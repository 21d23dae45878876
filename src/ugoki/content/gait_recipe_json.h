#pragma once
// JSON form of the recipe of a gait. Used by content and studio.

#include "ugoki/content/gait_recipe.h"
#include "ugoki/json/json.h"

namespace ugoki::content {

/// Reads a recipe; fields that are absent keep the values of `out`. Problems with types and unknown fields go to `problems`.
void read_gait_recipe(const json::Json& value, const std::string& location, GaitRecipe& out, Error& problems);
[[nodiscard]] json::Json to_json(const GaitRecipe& recipe);

}  // namespace ugoki::content
