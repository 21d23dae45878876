#pragma once
// The bodies of an MJCF model after frames, <replicate> and <attach> were expanded. Internal to robot_formats.

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

/// A joint of a body.
struct MjcfJoint {
  MjcfElement element;
  std::string name;  ///< with prefix and suffix; may be empty
  MjcfJointType type = MjcfJointType::hinge;
  Vec3 pos, axis;                               ///< in the body's frame; pos in m, axis a unit vector
  double ref = 0;                               ///< m or rad: MuJoCo's coordinate at the pose of the file, where Ugoki's coordinate is 0
  std::array<double, 2> springdamper = {0, 0};  ///< time constant [s], damping ratio; 0: not given
  Dof dof;                                      ///< properties of each of the joint's DOFs, with limits and rest position relative to q = 0
  int link = -1;                                ///< index in MechanismSpec::links; set by make_mjcf_links
};

/// A geom (shape with mass) of a body.
struct MjcfGeom {
  MjcfElement element;
  MjcfGeomType type = MjcfGeomType::sphere;
  Pose X_BG;                   ///< pose of the geom in the body's frame
  Vec3 size;                   ///< m, in MuJoCo's convention: half lengths and radii
  std::optional<double> mass;  ///< kg; overrides density
  double density = 1000;       ///< kg/m^3
  bool shell = false;          ///< shellinertia: mass on the surface
  int group = 0;
  int contype = 1, conaffinity = 1;
  int condim = 3;  ///< 1: no friction with geoms that have condim 1, too; 3: friction; 4, 6: also torsional and rolling friction
  double friction = 1;
  bool transparent = false;
  std::string mesh, height_field;  ///< names of assets; empty: none
};

/// A site: a named frame in a body.
struct MjcfSite {
  int body = 0;  ///< index in MjcfTree::bodies
  Pose X_BS;
};

/// A body with its joints and geoms.
struct MjcfBody {
  MjcfElement element;
  MjcfSource* source = nullptr;
  std::string name;      ///< with prefix and suffix; unique, never empty
  int parent = -1;       ///< index in MjcfTree::bodies; -1: this body is the world
  Pose X_PB;             ///< pose in the parent body's frame, with joints as in the file
  Pose X_WB;             ///< pose in the world, with joints as in the file
  bool mocap = false;    ///< moved by a program, not by physics
  MjcfElement inertial;  ///< <inertial>; empty if absent
  std::vector<MjcfJoint> joints;
  std::vector<MjcfGeom> geoms;
  const MjcfGeom* missing_mass = nullptr;  ///< a geom that should give mass to the body, but whose mesh file was not found; null: none
  int link = -1;  ///< index in MechanismSpec::links of the link with this body's mass and shapes; set by make_mjcf_links
  Pose X_LB;      ///< pose of the body frame in the frame of `link`
};

/// One occurrence of a model in the tree, and the prefix and suffix of its bodies' names. The first part is the main file.
struct MjcfPart {
  MjcfSource* source = nullptr;
  std::string prefix, suffix;
  bool attached = false;  ///< the part is a model of another file, perhaps only one of its bodies
  bool copied = false;    ///< the part is a copy of a <replicate>: a name is searched first with the suffix, then without it
};

/// All bodies of a model, and tables of its named objects.
struct MjcfTree {
  /// Location of a joint: index in MjcfTree::bodies, and index in MjcfBody::joints.
  struct JointIndex {
    std::size_t body, joint;
  };
  std::vector<MjcfBody> bodies;  ///< parents first; [0] is the world
  std::vector<MjcfPart> parts;
  std::map<std::string, std::size_t, std::less<>> body_named;
  std::map<std::string, JointIndex, std::less<>> joint_named;
  std::map<std::string, MjcfSite, std::less<>> site_named;
  /// Suffixes of the copies of an object inside a <replicate>. Key: kind and name, for example "joint knee" for a joint `knee`.
  std::map<std::string, std::vector<std::string>, std::less<>> copies;
  bool deformables_left_out = false;  ///< the model has deformable bodies, whose coordinates are part of its keyframes
};

/// Reads all bodies of the model. Problems and notes are recorded in the files of the elements.
[[nodiscard]] MjcfTree read_mjcf_tree(MjcfSource& source, const MjcfFiles& files);

}  // namespace ugoki::robot_formats
