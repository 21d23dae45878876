#pragma once
// Reads OpenSim models (.osim, versions 2 to 4) as mechanisms. docs/formats.md lists what is read.

#include <string_view>

#include "ugoki/robot_formats/robot_model.h"

namespace ugoki::robot_formats {

/// Reads bodies with their inertias, joints, ranges of coordinates, and contact spheres; muscles, markers, meshes and forces are left out.
/// A joint whose axes follow functions of its coordinates becomes the nearest joint of joint.h; the notes state its maximum deviation.
/// Joints with other combinations of axes become chains of joints with links without mass.
/// @param file_name part of the location of every problem
[[nodiscard]] Result<RobotModel> read_osim(std::string_view text, std::string_view file_name, const RobotOptions& options = {});

}  // namespace ugoki::robot_formats
