#pragma once
// Reads a file of any format of this module; the root element selects the format.

#include <optional>
#include <string_view>

#include "ugoki/robot_formats/robot_model.h"

namespace ugoki::robot_formats {

enum class RobotFormat { urdf, sdf, mjcf };

/// The format, from the name of the root element: <robot>, <sdf>, <mujoco>. std::nullopt for any other. O(length of the text before it)
[[nodiscard]] std::optional<RobotFormat> robot_format_of(std::string_view text);

/// Reads URDF, SDF or MJCF.
/// @param file_name appears in the location of every problem; files that the description refers to are searched relative to it
[[nodiscard]] Result<RobotModel> read_robot_file(std::string_view text, std::string_view file_name, const RobotOptions& options = {});

}  // namespace ugoki::robot_formats
