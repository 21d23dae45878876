#pragma once
// What every reader of this module gives, and the choices that their callers have.

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/mechanism/mechanism.h"

namespace ugoki::robot_formats {

/// A joint or a loop of the file, by the name that it has there.
struct JointName {
  std::string joint;
  std::string link;  ///< the link that it carries; for a loop the loop's name
};

/// A position of all joints that the file names (MJCF: keyframes).
struct NamedPosition {
  std::string name;
  std::vector<double> q;  ///< [nq]
};

struct RobotModel {
  MechanismPtr mechanism;
  std::vector<JointName> joints;  ///< tree joints in the order of the mechanism's links, without invented ones
  std::vector<Pose> X_BF;  ///< for each link of the mechanism: the file's frame of the link in the mechanism's (which lies at the joint)
  std::vector<std::string> driven;  ///< links whose joints the file calls driven; empty if it does not tell
  std::vector<NamedPosition> positions;
  std::vector<std::string> notes;  ///< sentences for people: what was approximated, repaired, left out
};

/// How the base of the tree is joined to the world where the file leaves it open.
enum class Base { by_file, fixed, floating };
/// Meshes that collide: taken as the box around them, demanded (a missing one is an error), or left out. Where a body's mass
/// comes from a mesh (MJCF) a missing one is an error as well, unless meshes are left out: then it weighs nothing.
enum class Meshes { box, require, none };
/// Inertia that no body can have: moved to the nearest possible one with a note, or refused.
enum class Inertias { repair, strict };

/// The bytes of a file that a description names, or an Error (code io: not there).
using AssetReader = std::function<Result<std::string>(const std::string& path)>;

/// A text that stands beside the description.
struct SideFile {
  std::string name, text;
};

struct RobotOptions {
  Base base = Base::by_file;
  Meshes meshes = Meshes::box;
  Inertias inertias = Inertias::repair;
  std::optional<SideFile> loops = {};  ///< URDF, SDF: YAML that names loops (loops_yaml.h)
  AssetReader read_asset = {};         ///< absent: no file beside the description is read
};

}  // namespace ugoki::robot_formats
