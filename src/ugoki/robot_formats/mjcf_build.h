#pragma once
// Converts the bodies of an MJCF model to links, joints and loops of a mechanism. Internal to robot_formats.

#include <cstddef>
#include <set>
#include <string>
#include <vector>

#include "ugoki/robot_formats/mjcf_tree.h"
#include "ugoki/robot_formats/robot_model.h"

namespace ugoki::robot_formats {

/// State of the conversion. Each of the functions below converts one section of the file and adds the result to this state.
struct MjcfBuild {
  MjcfTree tree;
  const RobotOptions& options;
  MechanismSpec spec = {};
  std::vector<MjcfElement> link_elements = {};  ///< [spec.links] element that defines the link, for error locations
  std::vector<MjcfElement> loop_elements = {};  ///< [spec.loops] element that defines the loop, for error locations
  std::vector<Pose> X_BF = {};                  ///< [spec.links] see RobotModel::X_BF
  std::vector<JointName> joints = {};
  std::vector<std::string> driven = {};  ///< links whose joints have an actuator
  std::vector<NamedPosition> positions = {};
  std::vector<MeshRead> meshes = {};

  [[nodiscard]] LinkSpec& link_of(const MjcfJoint& joint) { return spec.links[static_cast<std::size_t>(joint.link)]; }
  [[nodiscard]] Dof& dof_of(const MjcfJoint& joint) { return link_of(joint).joint.dofs[0]; }
  [[nodiscard]] MjcfJoint& joint_at(const MjcfTree::JointIndex& location) { return tree.bodies[location.body].joints[location.joint]; }
  /// Returns the joint, site or body that `name` means in `part`. Unknown names give null or, for bodies, -1. The body "" is the world (0).
  [[nodiscard]] MjcfJoint* find_joint(const MjcfPart& part, const std::string& name);
  [[nodiscard]] const MjcfSite* find_site(const MjcfPart& part, const std::string& name) const;
  [[nodiscard]] int find_body(const MjcfPart& part, const std::string& name) const;

  /// A name by which one element refers to another. kind: "body", "joint" or "site"
  struct Reference {
    const char* kind;
    std::string name;
  };
  /// Returns the parts for which an element of `part` is evaluated. Usually this is `part` itself. If a name means an object that a
  /// <replicate> has copied, there is one part for each copy. If a name is unknown, the result is empty and a problem is added. In an
  /// attached model a note is added instead, because the object may be in a section of that model that was not attached.
  [[nodiscard]] std::vector<MjcfPart> matching_parts(const MjcfElement& e, const MjcfPart& part, const std::vector<Reference>& names);
};

/// Sets size and pose of each primitive geom that is fitted to a mesh. As in MuJoCo, they are computed from the mesh's inertia.
void fit_mjcf_geoms(MjcfBody& body);

/// Returns mass [kg], centre of mass [m] and inertia [kg m^2] in the body's frame, from the body's <inertial> or from its geoms.
[[nodiscard]] Inertia mjcf_inertia(MjcfBody& body, const RobotOptions& options);

/// Returns the geom as a shape in the body's frame. If the geom is left out, adds a note and returns std::nullopt.
[[nodiscard]] std::optional<Shape> mjcf_shape(MjcfBody& body, const MjcfGeom& geom, MjcfBuild& build);

/// Makes the links of all bodies. Several joints of a body give a chain of massless links; the world's shapes give a link "world".
void make_mjcf_links(MjcfBuild& build);

/// Converts the attribute springdamper of joints as MuJoCo does. It specifies a time constant and a damping ratio of a DOF. Stiffness and
/// damping of the DOF are computed from these and from the DOF's inertia at the pose of the file; they replace the values in the file.
/// O(nv^3) if any joint has springdamper.
void set_mjcf_springs(MjcfBuild& build);

/// Reads <equality>: makes loops, and locks joints.
void read_mjcf_loops(MjcfBuild& build);

/// Reads <contact>: pairs of bodies that do not collide.
void read_mjcf_exclusions(MjcfBuild& build);

/// Reads <actuator>: sets effort limits, and lists the driven joints.
void read_mjcf_drives(MjcfBuild& build);
/// Adds notes about <tendon>, <deformable>, <option> and other elements that a mechanism cannot store.
void note_mjcf_left_out(const MjcfBuild& build);

/// Reads <keyframe> as named positions.
void read_mjcf_keyframes(MjcfBuild& build);

}  // namespace ugoki::robot_formats
