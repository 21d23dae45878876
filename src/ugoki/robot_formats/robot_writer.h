#pragma once
// Writes mechanisms as URDF and MJCF.

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/mechanism/mechanism.h"
#include "ugoki/robot_formats/robot_model.h"

namespace ugoki::robot_formats {

/// A description and its side files.
struct RobotText {
  std::string text;
  std::vector<SideFile> files;     ///< meshes (OBJ), and the YAML file that defines the loops of a URDF
  std::vector<std::string> notes;  ///< sentences for the user: what the format cannot store, or stores in another form
};

/// A motion that is written together with a mechanism.
struct RobotMotion {
  double rate = 0;            ///< frames per second
  std::span<const double> q;  ///< [frames][nq] position coordinates of the mechanism; empty: no motion
};

/// Writes URDF, and `stem`.yaml with the loops (loops_yaml.h) if there are any. Link frames, masses, inertias, axes, limits, damping,
/// friction and effort limits are exact; rotations, which URDF stores as angles, are exact to rounding. read_urdf() restores the same
/// links, and additional massless links at the frames of loops. Cylindrical, helical and universal joints become two joints with a massless
/// link between them. URDF cannot store springs, armature, friction and restitution of surfaces, ellipsoids, height fields, distance loops
/// and nonlinear gears. Each of these gives a note.
/// A motion becomes the table `stem`-motion.csv with a row for each frame: time [s] and the position of every joint, by the joint's name
/// (m, rad). Joints with several coordinates have columns NAME.x, .y, .z [m] and .qw, .qx, .qy, .qz (unit quaternion) or .angle; a base
/// without a joint has the columns of its link.
/// @param stem base name of the side files
[[nodiscard]] RobotText write_urdf(const Mechanism& mechanism, std::string_view stem, const RobotMotion& motion = {});

/// Writes MJCF for MuJoCo 2.2 and later: bodies at the link frames, meshes as inline vertices, motors for joints with an effort limit,
/// equalities for welds, ball loops, revolute loops (two points on the axis) and gears. Cylindrical, helical, planar and universal joints
/// become several joints of one body. Other loops, height fields, restitution and all else that MJCF cannot store give a note. Each frame
/// of a motion becomes a key of <keyframe> with time and qpos.
[[nodiscard]] RobotText write_mjcf(const Mechanism& mechanism, const RobotMotion& motion = {});

}  // namespace ugoki::robot_formats
