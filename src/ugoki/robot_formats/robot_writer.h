#pragma once
// Mechanisms as URDF and MJCF.

#include <string>
#include <string_view>
#include <vector>

#include "ugoki/mechanism/mechanism.h"
#include "ugoki/robot_formats/robot_model.h"

namespace ugoki::robot_formats {

/// A description and what belongs beside it.
struct RobotText {
  std::string text;
  std::vector<SideFile> files;     ///< meshes (OBJ), and the YAML file that names the loops of a URDF
  std::vector<std::string> notes;  ///< sentences: what the format cannot hold, or holds in other joints
};

/// URDF, with `stem`.yaml naming its loops (loops_yaml.h) where it has any. Link frames, masses, inertias, axes, limits, damping, friction
/// and effort are kept to the bit or, as angles of rotations, to rounding. Read back (read_urdf) it has the same links and, for loops,
/// links without mass at their frames; cylindrical, helical and universal joints become two joints with a link without mass between.
/// Springs, rotors' inertia, friction and restitution of surfaces, ellipsoids, height fields, distances and gears that are not linear have
/// no place in it; each is told.
/// @param stem of the names of files beside
[[nodiscard]] RobotText write_urdf(const Mechanism& mechanism, std::string_view stem);

/// MJCF for MuJoCo 2.2 and later: bodies at the links' frames, meshes inside, motors for joints whose effort is bounded, equalities for
/// welds, balls, revolute loops (two points on the axis) and gears. Cylindrical, helical, planar and universal joints become several joints
/// of one body. Other loops, height fields, restitution and what else it cannot hold is told.
[[nodiscard]] RobotText write_mjcf(const Mechanism& mechanism);

}  // namespace ugoki::robot_formats
