#pragma once
// The bodies of an MJCF model after frames, copies (replicate) and attached models are resolved. Internal to robot_formats.

#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "ugoki/mechanism/joint.h"
#include "ugoki/robot_formats/mjcf_source.h"

namespace ugoki::robot_formats {

enum class MjcfJointType { free, ball, slide, hinge };
enum class MjcfGeomType { plane, hfield, sphere, capsule, ellipsoid, cylinder, box, mesh, sdf };

struct MjcfJoint {
  MjcfElement element;
  std::string name;  ///< whole, with prefix and suffix; may be empty
  MjcfJointType type = MjcfJointType::hinge;
  Vec3 pos, axis;                               ///< in the body's frame; axis unit
  double ref = 0;                               ///< the coordinate that MuJoCo gives the position of the file; ours is 0 there
  std::array<double, 2> springdamper = {0, 0};  ///< time constant [s], damping ratio; 0: not given
  Freedom freedom;                              ///< of each of its freedoms, about our zero
  int link = -1;                                ///< index in the spec's links; set when these are made
};

struct MjcfGeom {
  MjcfElement element;
  MjcfGeomType type = MjcfGeomType::sphere;
  Pose X_BG;                   ///< in the body's frame
  Vec3 size;                   ///< m, as MuJoCo counts them: half lengths, radii
  std::optional<double> mass;  ///< kg; wins over density
  double density = 1000;       ///< kg/m^3
  bool shell = false;
  int group = 0;
  int contype = 1, conaffinity = 1;
  double friction = 1;
  bool transparent = false;
  std::string mesh, height_field;  ///< names of assets
};

struct MjcfSite {
  int body = 0;
  Pose X_BS;
};

struct MjcfBody {
  MjcfElement element;
  MjcfSource* source = nullptr;
  std::string name;  ///< whole, unique, never empty
  int parent = -1;   ///< -1: this is the world
  Pose X_PB;         ///< in the parent body's frame at the position of the file
  Pose X_WB;         ///< in the world at the position of the file
  bool mocap = false;
  MjcfElement inertial;  ///< may be none
  std::vector<MjcfJoint> joints;
  std::vector<MjcfGeom> geoms;
  const MjcfGeom* without_mass = nullptr;  ///< a geom whose mesh is not there, though the body's mass would come from it
  int link = -1;  ///< index in the spec's links of the link that carries its mass and shapes; set when these are made
  Pose X_LB;      ///< in that link's frame
};

/// A model whose bodies are in the tree, under names with a prefix and a suffix; the first one is the file itself.
struct MjcfPart {
  MjcfSource* source = nullptr;
  std::string prefix, suffix;
  bool attached = false;  ///< a model of another file, of which only a piece may have been taken
  bool copied = false;    ///< one copy of a <replicate>: names without the suffix are meant where none with it is
};

struct MjcfTree {
  struct JointPlace {
    std::size_t body, joint;
  };
  std::vector<MjcfBody> bodies;  ///< parents first; [0] is the world
  std::vector<MjcfPart> parts;
  std::map<std::string, std::size_t, std::less<>> body_named;
  std::map<std::string, JointPlace, std::less<>> joint_named;
  std::map<std::string, MjcfSite, std::less<>> site_named;
  /// "joint knee" of a <replicate>: the suffixes that its copies have.
  std::map<std::string, std::vector<std::string>, std::less<>> copies;
  bool parts_left_out = false;  ///< deformable things, whose coordinates the model's keyframes contain
};

/// Problems and notes go to the files of the elements.
[[nodiscard]] MjcfTree read_mjcf_tree(MjcfSource& source, const MjcfFiles& files);

}  // namespace ugoki::robot_formats
