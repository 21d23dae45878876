#pragma once
// Writes mechanisms as URDF and MJCF.

#include <string>
#include <string_view>
#include <vector>

#include "ugoki/mechanism/mechanism.h"
#include "ugoki/robot_formats/robot_model.h"

namespace ugoki::robot_formats {

/// A robot description and its side files.
struct RobotText {
  std::string text;
  std::vector<SideFile> files;     ///< meshes (OBJ), and the YAML file that defines the loops of a URDF
  std::vector<std::string> notes;  ///< sentences for the user about data that the format cannot store, or stores in another form
};

/// Writes URDF, and `stem`.yaml with the loops (loops_yaml.h) if there are any. Link frames, masses, inertias, axes, limits, damping,
/// friction and effort limits are exact; rotations, which URDF stores as angles, are exact up to rounding. read_urdf() restores the same
/// links, and adds massless links at the frames of loops. Cylindrical, helical and universal joints become two joints with a massless link
/// between them. URDF cannot store springs, armature, friction and restitution of surfaces, ellipsoids, height fields, distance loops and
/// nonlinear gears. Each of these gives a note.
/// @param stem file name of the side files without extension
[[nodiscard]] RobotText write_urdf(const Mechanism& mechanism, std::string_view stem);

/// Writes MJCF for MuJoCo 2.2 and later: bodies at the link frames, meshes as inline vertices, motors for joints with an effort limit,
/// equalities for welds, ball loops, revolute loops (two points on the axis) and gears. Cylindrical, helical, planar and universal joints
/// become several joints of one body. Other loops, height fields, restitution and all other data that MJCF cannot store give a note.
[[nodiscard]] RobotText write_mjcf(const Mechanism& mechanism);

}  // namespace ugoki::robot_formats
