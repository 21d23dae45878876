#pragma once
// Reads MuJoCo's XML format (MJCF) as a mechanism. docs/formats.md lists which elements are read and which are left out.

#include <string_view>

#include "ugoki/robot_formats/robot_model.h"

namespace ugoki::robot_formats {

/// Reads a model with all files that it includes or attaches. Every body becomes a link of the same name. Several joints of a body become a
/// chain of massless links named "body:joint". Coordinates are shifted so that q = 0 is the pose written in the file; for hinges and slides
/// q = MuJoCo's qpos - ref. A floating base at q = 0 is at its joint frame X_PJ:
/// MuJoCo's free-joint pose = X_PJ * our joint's pose.
/// Equalities become loops, actuators become effort limits of their joints, keyframes become named positions.
/// @param file_name name of the model, and part of the location of every problem; other files are searched relative to its folder
/// Errors: at most 20 problems, each with file:line and a remedy. O(text + bodies log bodies).
[[nodiscard]] Result<RobotModel> read_mjcf(std::string_view text, std::string_view file_name, const RobotOptions& options = {});

}  // namespace ugoki::robot_formats
