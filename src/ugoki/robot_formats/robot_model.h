#pragma once
// Result type and options of all readers of this module.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/mechanism/mechanism.h"

namespace ugoki::robot_formats {

/// A joint or loop of the file, and the corresponding link or loop of the mechanism.
struct JointName {
  std::string joint;  ///< name in the file
  std::string link;   ///< link below the joint in the tree; for a loop, the loop's name
};

/// A named position of the mechanism: coordinates of all joints (MJCF: a keyframe).
struct NamedPosition {
  std::string name;
  std::vector<double> q;  ///< [nq]
};

/// A mesh file that was converted to a shape.
struct MeshRead {
  std::string file;
  std::size_t points = 0, triangles = 0;  ///< counts in the file
  std::uint64_t geometry = 0;             ///< hash of the geometry made from the mesh; 0: the mesh was replaced by a box
  GeometryFindings found;                 ///< defects found in the mesh; only for exact surfaces
};

/// A mechanism read from a file.
struct RobotModel {
  MechanismPtr mechanism;
  std::vector<JointName> joints;    ///< tree joints in the order of the mechanism's links (without generated joints), then loops
  std::vector<Pose> X_BF;           ///< [links] pose of the file's link frame in the mechanism's link frame (which is at the joint)
  std::vector<std::string> driven;  ///< links whose joints the file declares as actuated; empty if it declares none
  std::vector<NamedPosition> positions;
  std::vector<MeshRead> meshes;    ///< one entry for each combination of file, scale and use (collision or display)
  std::vector<std::string> notes;  ///< sentences for the user about approximations, repairs and omissions
};

/// Connection of the tree's base to the world, if the file does not specify it. by_file: according to the convention of the format.
enum class Base { by_file, fixed, floating };
/// Form in which meshes are used: exact surface, convex hull, bounding box, or not at all. If a body's mass comes from a mesh (MJCF), a
/// missing mesh file is an error; with `none` the mesh contributes no mass.
enum class Meshes { exact, hull, box, none };
/// Treatment of physically impossible inertia: it is replaced by the nearest possible one, with a note, or it is refused.
enum class Inertias { repair, strict };

/// Returns the bytes of a file that a description refers to, or an Error (code io: not found).
using AssetReader = std::function<Result<std::string>(const std::string& path)>;

/// A text file that belongs to a robot description.
struct SideFile {
  std::string name, text;
};

struct RobotOptions {
  Base base = Base::by_file;
  Meshes meshes = Meshes::hull;
  bool require_meshes = false;  ///< true: a collision mesh that is missing or cannot be used is an error; false: it gives a note
  Inertias inertias = Inertias::repair;
  std::optional<SideFile> loops = {};  ///< URDF, SDF: YAML file that defines the loops (loops_yaml.h)
  AssetReader read_asset = {};         ///< null: no other file is read
};

}  // namespace ugoki::robot_formats
