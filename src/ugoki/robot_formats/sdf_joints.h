#pragma once
// The joints of an SDF model, as they stand in the file: a graph, not a tree; internal to robot_formats.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "ugoki/mechanism/joint.h"
#include "ugoki/mechanism/loop.h"
#include "ugoki/robot_formats/sdf_frames.h"

namespace ugoki::robot_formats {

/// A joint between the links (frame indices; -1: the world) `parent` and `child`.
struct SdfJoint {
  pugi::xml_node node;
  std::string name;
  int parent = -1, child = -1;
  Pose X_PJ, X_CJ;  ///< where it lies in the parent link, in the child link (the file's frames of the links)
  Joint motion;     ///< its X_PJ is not used
};

/// `<joint type="gearbox">`: couples the angles of two links against a third.
struct SdfGearbox {
  pugi::xml_node node;
  std::string name, scope;
  int parent = -1, child = -1, reference = -1;  ///< links
  Vec3 axis_W, axis2_W;
  double ratio = 1;
};

/// A `<mimic>` of an axis: follower = multiplier (leader - reference) + offset.
struct SdfMimic {
  pugi::xml_node node;
  std::string follower, leader;  ///< names of joints
  double multiplier = 1, reference = 0, offset = 0;
};

/// A closure that is no joint: `drake:weld_constraint`, `drake:ball_constraint`, `drake:linear_bushing_rpy`.
struct SdfClosure {
  pugi::xml_node node;
  std::string name;
  LoopType type = LoopType::weld;
  int a = -1, b = -1;  ///< links
  Pose X_AJ, X_BJ;
};

struct SdfJoints {
  std::vector<SdfJoint> joints;
  std::vector<SdfGearbox> gearboxes;
  std::vector<SdfMimic> mimics;
  std::vector<SdfClosure> closures;
};

/// Reads the joint `node`, whose frame has the index `frame`.
void read_sdf_joint(XmlFields& xml, SdfFrames& frames, int version, int frame, SdfJoints& out);

/// Reads the element if it is one of Drake's closures. @return whether it is
bool read_sdf_closure(XmlFields& xml, const SdfFrames& frames, std::string_view scope, pugi::xml_node node, SdfJoints& out);

/// The same joint seen from its child: same coordinates, or their mirror image where a ball or universal joint has several.
[[nodiscard]] Joint reversed(const Joint& joint);

/// The loop type whose condition leaves the joint's freedoms; nothing for those that no loop has.
[[nodiscard]] std::optional<LoopType> loop_type_of(const Joint& joint);

}  // namespace ugoki::robot_formats
