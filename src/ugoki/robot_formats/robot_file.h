#pragma once
// Reads a file of any format of this module; the root element selects the format.

#include <optional>
#include <string_view>

#include "ugoki/robot_formats/robot_model.h"

namespace ugoki::robot_formats {

enum class RobotFormat { urdf, sdf, mjcf, osim };

/// Returns the format for the root element's name: <robot>, <sdf>, <mujoco>, <OpenSimDocument>; std::nullopt for others. O(length of the
/// text before it)
[[nodiscard]] std::optional<RobotFormat> robot_format_of(std::string_view text);

/// Reads URDF, SDF, MJCF or an OpenSim model.
/// @param file_name part of the location of every problem; files that the description refers to are searched relative to it
[[nodiscard]] Result<RobotModel> read_robot_file(std::string_view text, std::string_view file_name, const RobotOptions& options = {});

}  // namespace ugoki::robot_formats
