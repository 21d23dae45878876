#pragma once
// SDFormat 1.4 to 1.9: links, joints and frames of a model (sdformat.org/spec). What is read, and how, is in docs/formats.md.

#include <string_view>

#include "ugoki/robot_formats/robot_model.h"

namespace ugoki::robot_formats {

/// The first model that is not static, nested models included. Joints that close a loop become the mechanism's loops.
/// @param file_name stands in the place of every problem; files that the description names are looked for near it
[[nodiscard]] Result<RobotModel> read_sdf(std::string_view text, std::string_view file_name, const RobotOptions& options = {});

}  // namespace ugoki::robot_formats
