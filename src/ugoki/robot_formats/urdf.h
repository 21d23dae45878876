#pragma once
// URDF: links and joints of a robot (wiki.ros.org/urdf/XML). What is read, and how, is in docs/formats.md.

#include <string_view>

#include "ugoki/robot_formats/robot_model.h"

namespace ugoki::robot_formats {

/// @param file_name stands in the place of every problem; files that the description names are looked for near it
[[nodiscard]] Result<RobotModel> read_urdf(std::string_view text, std::string_view file_name, const RobotOptions& options = {});

}  // namespace ugoki::robot_formats
