#pragma once
// Any of the module's formats, told apart by what the file says.

#include <optional>
#include <string_view>

#include "ugoki/robot_formats/robot_model.h"

namespace ugoki::robot_formats {

enum class RobotFormat { urdf, sdf, mjcf };

/// By the outermost element: <robot>, <sdf>, <mujoco>. O(what stands before it)
[[nodiscard]] std::optional<RobotFormat> robot_format_of(std::string_view text);

/// @param file_name stands in the place of every problem; files that the description names are looked for near it
[[nodiscard]] Result<RobotModel> read_robot_file(std::string_view text, std::string_view file_name, const RobotOptions& options = {});

}  // namespace ugoki::robot_formats
