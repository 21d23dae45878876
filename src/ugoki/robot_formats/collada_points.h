#pragma once
// The vertices of a COLLADA mesh; internal to robot_formats.

#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/spatial/spatial.h"

namespace ugoki::robot_formats {

/// Positions [m] of every geometry that the scene's nodes place, in the scene's own axes (as the viewers of robot
/// descriptions take them); without a scene those of every geometry. Skins and library nodes are not followed.
[[nodiscard]] Result<std::vector<Vec3>> collada_points(std::string_view text, const std::string& file_name);

}  // namespace ugoki::robot_formats
