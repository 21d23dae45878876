#pragma once
// MuJoCo's XML (MJCF) as mechanisms. What is read and what is left out: docs/formats.md.

#include <string_view>

#include "ugoki/robot_formats/robot_model.h"

namespace ugoki::robot_formats {

/// Reads a model with all that it includes and attaches. Every body becomes a link of its name; several joints of one body
/// become a chain of links without mass, "body:joint". Every joint's coordinate is 0, and every floating base at its
/// joint's frame, at the position of the file: q = MuJoCo's qpos - ref, and MuJoCo's free joint is X_PJ times ours.
/// Equalities become loops, drives the efforts of their joints, keyframes positions.
/// @param file_name names the model and stands in the place of every problem; other files are relative to its folder
/// Errors: at most twenty problems, each with file:line and a remedy. O(text + bodies log bodies).
[[nodiscard]] Result<RobotModel> read_mjcf(std::string_view text, std::string_view file_name, const RobotOptions& options = {});

}  // namespace ugoki::robot_formats
