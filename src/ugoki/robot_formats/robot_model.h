#pragma once
// What every reader of this module gives, and the choices that their callers have.

#include <cstdint>
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

/// A mesh file that became a shape.
struct MeshRead {
  std::string file;
  std::size_t points = 0, triangles = 0;  ///< in the file
  std::uint64_t geometry = 0;             ///< hash of the geometry that it became; 0: a box
  GeometryFindings found;                 ///< exact surfaces: what was mended
};

struct RobotModel {
  MechanismPtr mechanism;
  std::vector<JointName> joints;  ///< tree joints in the order of the mechanism's links, without invented ones
  std::vector<Pose> X_BF;  ///< for each link of the mechanism: the file's frame of the link in the mechanism's (which lies at the joint)
  std::vector<std::string> driven;  ///< links whose joints the file calls driven; empty if it does not tell
  std::vector<NamedPosition> positions;
  std::vector<MeshRead> meshes;    ///< each file (and scale) once
  std::vector<std::string> notes;  ///< sentences for people: what was approximated, repaired, left out
};

/// How the base of the tree is joined to the world where the file leaves it open.
enum class Base { by_file, fixed, floating };
/// Meshes: taken as their surface, their convex hull or the box around them, or left out. Where a body's mass comes from a mesh
/// (MJCF) a missing one is an error, unless meshes are left out: then it weighs nothing.
enum class Meshes { exact, hull, box, none };
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
  Meshes meshes = Meshes::hull;
  bool require_meshes = false;  ///< a mesh that collides and is absent or cannot be used is an error, not a note
  Inertias inertias = Inertias::repair;
  std::optional<SideFile> loops = {};  ///< URDF, SDF: YAML that names loops (loops_yaml.h)
  AssetReader read_asset = {};         ///< absent: no file beside the description is read
};

}  // namespace ugoki::robot_formats
