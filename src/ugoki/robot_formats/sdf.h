#pragma once
// Reads SDFormat 1.4 to 1.9: links, joints and frames of a model (sdformat.org/spec). docs/formats.md lists what is read.

#include <string_view>

#include "ugoki/robot_formats/robot_model.h"

namespace ugoki::robot_formats {

/// Reads the first model that is not static (or the first model, if all are static), with its nested models. Joints that close a loop
/// become loops of the mechanism.
/// @param file_name part of the location of every problem; files that the description refers to are searched relative to it
[[nodiscard]] Result<RobotModel> read_sdf(std::string_view text, std::string_view file_name, const RobotOptions& options = {});

}  // namespace ugoki::robot_formats
