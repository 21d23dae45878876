#pragma once
// Reads URDF: links and joints of a robot (wiki.ros.org/urdf/XML). docs/formats.md lists what is read.

#include <string_view>

#include "ugoki/robot_formats/robot_model.h"

namespace ugoki::robot_formats {

/// Reads a robot description in URDF.
/// @param file_name part of the location of every problem; files that the description refers to are searched relative to it
[[nodiscard]] Result<RobotModel> read_urdf(std::string_view text, std::string_view file_name, const RobotOptions& options = {});

}  // namespace ugoki::robot_formats
