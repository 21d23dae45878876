#pragma once
// The joints of an SDF model as the file defines them: a graph, not yet a tree. Internal to robot_formats.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "ugoki/mechanism/joint.h"
#include "ugoki/mechanism/loop.h"
#include "ugoki/robot_formats/sdf_frames.h"

namespace ugoki::robot_formats {

/// A joint between two links. `parent` and `child` are frame indices of links; -1: the world.
struct SdfJoint {
  pugi::xml_node node;
  std::string name;
  int parent = -1, child = -1;
  Pose X_PJ, X_CJ;  ///< as in the file: pose of the joint frame in the frame of the parent link and in the frame of the child link
  Joint motion;     ///< type, axes and DOF properties; the member X_PJ of this Joint is not used
};

/// `<joint type="gearbox">`: couples the angles of two links relative to a third link.
struct SdfGearbox {
  pugi::xml_node node;
  std::string name, scope;
  int parent = -1, child = -1, reference = -1;  ///< frame indices of the three links
  Vec3 axis_W, axis2_W;                         ///< rotation axes of the parent and of the child, in world axes
  double ratio = 1;                             ///< angle of the child = -ratio * angle of the parent
};

/// A `<mimic>` of an axis: q_follower = multiplier (q_leader - reference) + offset, q: joint coordinate.
struct SdfMimic {
  pugi::xml_node node;
  std::string follower, leader;                      ///< names of joints
  double multiplier = 1, reference = 0, offset = 0;  ///< reference, offset: m or rad
};

/// A loop closure that is not a joint: `drake:weld_constraint`, `drake:ball_constraint`, `drake:linear_bushing_rpy`.
struct SdfClosure {
  pugi::xml_node node;
  std::string name;
  LoopType type = LoopType::weld;
  int a = -1, b = -1;  ///< frame indices of links; -1: the world
  Pose X_AJ, X_BJ;     ///< as in the file: poses of the closure's two frames, X_AJ in the frame of link a, X_BJ in the frame of link b
};

/// All joints and closures of a model.
struct SdfJoints {
  std::vector<SdfJoint> joints;
  std::vector<SdfGearbox> gearboxes;
  std::vector<SdfMimic> mimics;
  std::vector<SdfClosure> closures;
};

/// Reads the joint whose frame has the index `frame`, and adds it to `out`.
void read_sdf_joint(XmlFields& xml, SdfFrames& frames, int version, int frame, SdfJoints& out);

/// Reads the element if it is one of Drake's closures. Returns true if it is one.
bool read_sdf_closure(XmlFields& xml, const SdfFrames& frames, std::string_view scope, pugi::xml_node node, SdfJoints& out);

/// Returns the joint with parent and child exchanged. Its coordinates have the same values; those of a universal joint are stored in
/// reverse order.
[[nodiscard]] Joint reversed(const Joint& joint);

/// Returns the loop type with the same free DOFs as the joint; std::nullopt if there is none.
[[nodiscard]] std::optional<LoopType> loop_type_of(const Joint& joint);

}  // namespace ugoki::robot_formats
