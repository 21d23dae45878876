#pragma once
// From the bodies of an MJCF model to the parts of a mechanism. Internal to robot_formats.

#include <cstddef>
#include <set>
#include <string>
#include <vector>

#include "ugoki/robot_formats/mjcf_tree.h"
#include "ugoki/robot_formats/robot_model.h"

namespace ugoki::robot_formats {

/// What the readers of the sections add to.
struct MjcfBuild {
  MjcfTree tree;
  const RobotOptions& options;
  MechanismSpec spec = {};
  std::vector<MjcfElement> link_elements = {};  ///< beside spec.links: where each stands in the file
  std::vector<MjcfElement> loop_elements = {};  ///< beside spec.loops
  std::vector<Pose> X_BF = {};                  ///< beside spec.links: RobotModel::X_BF
  std::vector<JointName> joints = {};
  std::vector<std::string> driven = {};
  std::vector<NamedPosition> positions = {};
  std::vector<MeshRead> meshes = {};

  [[nodiscard]] LinkSpec& link_of(const MjcfJoint& joint) { return spec.links[static_cast<std::size_t>(joint.link)]; }
  [[nodiscard]] Freedom& freedom_of(const MjcfJoint& joint) { return link_of(joint).joint.freedoms[0]; }
  [[nodiscard]] MjcfJoint& joint_at(const MjcfTree::JointPlace& place) { return tree.bodies[place.body].joints[place.joint]; }
  /// What `name` means in the part, or null, or -1 (no body; "" is the world).
  [[nodiscard]] MjcfJoint* find_joint(const MjcfPart& part, const std::string& name);
  [[nodiscard]] const MjcfSite* find_site(const MjcfPart& part, const std::string& name) const;
  [[nodiscard]] int find_body(const MjcfPart& part, const std::string& name) const;

  /// A name by which an element means another one. kind: "body", "joint" or "site"
  struct Reference {
    const char* kind;
    std::string name;
  };
  /// The parts for which an element of `part` holds: the part itself; or, where it names what a <replicate> copied, every copy;
  /// or none where a name means nothing, which is a problem (in an attached model, of which a piece may be missing, a note).
  [[nodiscard]] std::vector<MjcfPart> parts_of(const MjcfElement& e, const MjcfPart& part, const std::vector<Reference>& names);
};

/// Geoms that a primitive and a mesh describe become the primitive of the mesh's moments of inertia.
void fit_mjcf_geoms(MjcfBody& body);

/// Mass properties in the body's frame: of its <inertial>, or of its geoms. kg, m.
[[nodiscard]] Inertia mjcf_inertia(MjcfBody& body, const RobotOptions& options);

/// The geom as a shape in the body's frame; nothing, with a note, where it is left out.
[[nodiscard]] std::optional<Shape> mjcf_shape(MjcfBody& body, const MjcfGeom& geom, MjcfBuild& build);

/// Links of all bodies: a chain of links without mass for several joints of one body, a link "world" for the world's shapes.
void make_mjcf_links(MjcfBuild& build);

/// springdamper of joints: as in MuJoCo, spring and damper that give the freedom's inertia at the position of the file this time
/// constant and damping ratio; both replace stiffness and damping. O(nv^3) where there are any.
void set_mjcf_springs(MjcfBuild& build);

/// <equality>: loops, and joints held fast.
void read_mjcf_loops(MjcfBuild& build);

/// <actuator>: efforts and driven joints; <tendon>, <contact>, <deformable>, <option> ...: notes.
void read_mjcf_drives(MjcfBuild& build);
void note_mjcf_left_out(const MjcfBuild& build);

/// <keyframe>: named positions.
void read_mjcf_keyframes(MjcfBuild& build);

}  // namespace ugoki::robot_formats
