#include "ugoki/robot_formats/sdf_joints.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace ugoki::robot_formats {
namespace {

using formats::in_quotes;

/// True if a and b are equal up to rounding: 1e-9 m and about 1e-6 rad.
bool same(const Pose& a, const Pose& b) {
  const Pose d = a.inverse() * b;
  return norm(d.p) < 1e-9 && d.R.trace() > 3 - 1e-12;
}

class SdfJointReader {
 public:
  SdfJointReader(XmlFields& xml, SdfFrames& frames, int version, int frame, SdfJoints& out)
      : xml_(xml), frames_(frames), version_(version), self_(frames.at(frame)), node_(self_.node), out_(out) {}

  void read() {
    xml_.note_unread(node_, {"parent", "child", "pose", "axis", "axis2", "gearbox_ratio", "gearbox_reference_body", "thread_pitch",
                             "screw_thread_pitch", "physics", "sensor"});
    const int parent = end("parent"), child = end("child");
    if (parent < 0 || child < 0) return;
    const int parent_link = frames_.at(parent).link, child_link = frames_.at(child).link;
    if (parent_link == child_link) {
      xml_.problem(node_, ErrorCode::structure, xml_.title(node_) + " connects a link to itself.", "Name two different links.");
      return;
    }
    if (xml_.attribute(node_, "type").text == "gearbox") return read_gearbox(parent_link, child_link);
    SdfJoint joint{node_, self_.name, parent_link, child_link, {}, {}, motion()};
    joint.X_CJ = in_link(child_link, self_.X_W);
    joint.X_PJ = in_link(parent_link, parent_side(parent, child_link));
    read_mimic();
    out_.joints.push_back(std::move(joint));
  }

 private:
  Pose in_link(int link, const Pose& X_W) const { return link < 0 ? X_W : frames_.at(link).X_W.inverse() * X_W; }

  /// Returns the index of the frame named by `<parent>` or `<child>`. If there is none, adds a problem and returns -1.
  int end(const char* which) {
    const std::string name = xml_.required_text(xml_.element(node_, which));
    const int i = name.empty() ? -1 : frames_.find(self_.scope, name);
    if (i < 0 && !name.empty())
      xml_.problem(xml_.element(node_, which), ErrorCode::unknown, ": " + in_quotes(name) + " does not exist.", "Name a link or a frame.");
    return i;
  }

  /// Returns the joint frame, in the world, as seen from the parent. Normally this is the joint's own frame, because the file's link poses
  /// make both sides coincide. If the child link has no <pose> and the joint names a <frame> as its parent, this frame is the joint frame.
  Pose parent_side(int parent, int child_link) {
    const SdfFrame& named = frames_.at(parent);
    const bool explicit_frame = named.kind == SdfFrameKind::frame;
    if (!explicit_frame || same(named.X_W, self_.X_W) || (child_link >= 0 && frames_.at(child_link).node.child("pose"))) return self_.X_W;
    xml_.note(node_, "Links without a <pose> are placed at the parent frames of their joints.");
    return named.X_W;
  }

  /// Reads type, axes, pitch and DOF properties of the joint.
  Joint motion() {
    static const std::map<std::string_view, JointType> types = {{"fixed", JointType::fixed},         {"revolute", JointType::revolute},
                                                                {"continuous", JointType::revolute}, {"prismatic", JointType::prismatic},
                                                                {"ball", JointType::spherical},      {"universal", JointType::universal},
                                                                {"revolute2", JointType::universal}, {"screw", JointType::helical}};
    Joint joint;
    const XmlField type = xml_.attribute(node_, "type");
    const auto it = types.find(type.text);
    if (it == types.end()) {
      xml_.problem(type, ErrorCode::unsupported, ": " + in_quotes(type.text) + " is not a joint type.",
                   "Use fixed, revolute, continuous, prismatic, ball, universal, revolute2, screw or gearbox.");
      return joint;
    }
    joint.type = it->second;
    const pugi::xml_node axis = node_.child("axis"), axis2 = node_.child("axis2");
    if (joint.nv() == 1 || joint.type == JointType::universal) joint.axis = direction(axis);
    if (joint.type == JointType::universal) joint.axis2 = direction(axis2);
    if (joint.type == JointType::helical) joint.pitch = pitch();
    for (int i = 0; i < joint.nv(); ++i)
      joint.dofs[static_cast<std::size_t>(i)] = dof(i == 1 && joint.type == JointType::universal ? axis2 : axis, type.text != "continuous");
    return joint;
  }

  /// Reads `<xyz>` of an axis, as a unit vector in the joint's frame.
  Vec3 direction(pugi::xml_node axis) {
    if (!axis) {
      xml_.problem(node_, ErrorCode::syntax, xml_.title(node_) + " has no axis.", "Add <axis> with <xyz>.");
      return {0, 0, 1};
    }
    const pugi::xml_node xyz = axis.child("xyz");
    const Vec3 a = xml_.direction(xml_.element(axis, "xyz"), {0, 0, 1});
    std::string in = xml_.text(xml_.attribute(xyz, "expressed_in"));
    if (version_ <= 104 || xml_.flag(xml_.element(axis, "use_parent_model_frame"), false)) in = "__model__";
    if (in.empty()) return a;
    const int frame = frames_.find(self_.scope, in);
    if (frame < 0) {
      xml_.problem(xyz, ErrorCode::unknown, "The frame " + in_quotes(in) + " of the axis does not exist.",
                   "Name a link, joint or frame of this model.");
      return a;
    }
    return transpose_times(self_.X_W.R, frames_.at(frame).X_W.R * a);
  }

  /// Reads the pitch of a screw joint, m/rad. The old element <thread_pitch> is in rad/m with the opposite sign, as in Gazebo and
  /// libsdformat.
  double pitch() {
    if (const XmlField turn = xml_.element(node_, "screw_thread_pitch"); turn.present) return xml_.number(turn, 0) / (2 * pi);
    const double old = xml_.number(xml_.element(node_, "thread_pitch"), 1);
    if (std::fabs(old) >= 1e-9) return -1 / old;
    xml_.problem(node_, ErrorCode::range, xml_.title(node_) + " has a thread pitch of zero.",
                 "Give <screw_thread_pitch> in metres per turn.");
    return 0;
  }

  Dof dof(pugi::xml_node axis, bool limited) {
    Dof f;
    const pugi::xml_node limit = axis.child("limit"), dynamics = axis.child("dynamics");
    if (limited) {
      f.lower = xml_.limit(xml_.element(limit, "lower"), f.lower);
      f.upper = xml_.limit(xml_.element(limit, "upper"), f.upper);
      if (f.lower > f.upper)
        xml_.problem(limit, ErrorCode::range, "The lower limit of " + xml_.title(node_) + " is greater than the upper limit.",
                     "Swap or correct the limits.");
    }
    if (const double effort = xml_.limit(xml_.element(limit, "effort"), -1); effort >= 0) f.effort = effort;  // negative: unlimited
    if (limit.child("velocity")) xml_.note("Maximum velocities of joints are not used.");
    f.damping = xml_.number(xml_.element(dynamics, "damping"), 0, not_negative);
    f.friction = xml_.number(xml_.element(dynamics, "friction"), 0, not_negative);
    f.stiffness = xml_.number(xml_.element(dynamics, "spring_stiffness"), 0, not_negative);
    f.rest = xml_.number(xml_.element(dynamics, "spring_reference"), 0);
    return f;
  }

  void read_gearbox(int parent, int child) {
    SdfGearbox gear{node_, self_.name, self_.scope, parent, child, -1, {}, {}, xml_.number(xml_.element(node_, "gearbox_ratio"), 1)};
    const std::string reference = xml_.required_text(xml_.element(node_, "gearbox_reference_body"));
    const int i = frames_.find(self_.scope, reference);
    if (i < 0) {
      if (!reference.empty())
        xml_.problem(node_, ErrorCode::unknown, "The reference link " + in_quotes(reference) + " does not exist.",
                     "Name a link of this model.");
      return;
    }
    gear.reference = frames_.at(i).link;
    gear.axis_W = self_.X_W.R * direction(node_.child("axis"));
    gear.axis2_W = node_.child("axis2") ? self_.X_W.R * direction(node_.child("axis2")) : gear.axis_W;
    out_.gearboxes.push_back(std::move(gear));
  }

  void read_mimic() {
    const pugi::xml_node mimic = node_.child("axis").child("mimic");
    if (!mimic) return;
    const std::string leader = xml_.required_text(xml_.attribute(mimic, "joint"));
    out_.mimics.push_back({mimic, self_.name, self_.scope + leader, xml_.number(xml_.element(mimic, "multiplier"), 1),
                           xml_.number(xml_.element(mimic, "reference"), 0), xml_.number(xml_.element(mimic, "offset"), 0)});
  }

  XmlFields& xml_;
  SdfFrames& frames_;
  int version_;
  const SdfFrame& self_;
  pugi::xml_node node_;
  SdfJoints& out_;
};

/// Returns the index of the frame that the child element names. If there is none, adds a problem and returns -1.
int named_frame(XmlFields& xml, const SdfFrames& frames, std::string_view scope, pugi::xml_node node, const char* element) {
  const std::string name = xml.required_text(xml.element(node, element));
  const int i = name.empty() ? -1 : frames.find(scope, name);
  if (i < 0 && !name.empty())
    xml.problem(xml.element(node, element), ErrorCode::unknown, ": " + in_quotes(name) + " does not exist.", "Name a link or a frame.");
  return i;
}

/// Returns the loop type whose free DOFs are exactly those in which the bushing has no stiffness; std::nullopt if there is no such type.
std::optional<LoopType> bushing_type(XmlFields& xml, pugi::xml_node node) {
  const Vec3 force = xml.vec3(xml.element(node, "drake:bushing_force_stiffness"), {}, not_negative);
  const Vec3 torque = xml.vec3(xml.element(node, "drake:bushing_torque_stiffness"), {}, not_negative);
  if (!(force.x > 0 && force.y > 0 && force.z > 0)) return std::nullopt;
  if (torque.x > 0 && torque.y > 0) return torque.z > 0 ? LoopType::weld : LoopType::revolute;  // the axis of `revolute` is z
  if (torque.x == 0 && torque.y == 0 && torque.z == 0) return LoopType::ball;
  return std::nullopt;
}

}  // namespace

void read_sdf_joint(XmlFields& xml, SdfFrames& frames, int version, int frame, SdfJoints& out) {
  SdfJointReader(xml, frames, version, frame, out).read();
}

bool read_sdf_closure(XmlFields& xml, const SdfFrames& frames, std::string_view scope, pugi::xml_node node, SdfJoints& out) {
  const std::string_view kind = node.name();
  const bool weld = kind == "drake:weld_constraint", ball = kind == "drake:ball_constraint", bushing = kind == "drake:linear_bushing_rpy";
  if (!weld && !ball && !bushing) return false;
  std::optional<LoopType> type = weld ? LoopType::weld : LoopType::ball;
  if (bushing) type = bushing_type(xml, node);
  if (!type) {
    xml.problem(node, ErrorCode::unsupported, "A bushing with this combination of stiff axes is not supported.",
                "Use a joint, or make the bushing stiff in all directions, or in all but rotation about z, or in translation only.");
    return true;
  }
  if (bushing) xml.note(node, "A bushing is replaced by a rigid loop closure, without its compliance.");
  const char* names[2] = {weld   ? "parent"
                          : ball ? "drake:ball_constraint_body_A"
                                 : "drake:bushing_frameA",
                          weld   ? "child"
                          : ball ? "drake:ball_constraint_body_B"
                                 : "drake:bushing_frameC"};
  const int a = named_frame(xml, frames, scope, node, names[0]), b = named_frame(xml, frames, scope, node, names[1]);
  if (a < 0 || b < 0) return true;
  const auto in_link = [&](int frame) {
    const int link = frames.at(frame).link;
    return link < 0 ? frames.at(frame).X_W : frames.at(link).X_W.inverse() * frames.at(frame).X_W;
  };
  SdfClosure closure{node, xml.text(xml.attribute(node, "name")), *type, frames.at(a).link, frames.at(b).link, in_link(a), in_link(b)};
  if (ball) {
    closure.X_AJ.p = closure.X_AJ * xml.vec3(xml.element(node, "drake:ball_constraint_p_AP"), {});
    closure.X_BJ.p = closure.X_BJ * xml.vec3(xml.element(node, "drake:ball_constraint_p_BQ"), {});
  }
  if (closure.a == closure.b) {
    xml.problem(node, ErrorCode::structure, "A closure connects a link to itself.", "Name frames of two different links.");
    return true;
  }
  if (closure.name.empty()) closure.name = std::string(kind.substr(6)) + " " + std::to_string(out.closures.size() + 1);
  out.closures.push_back(std::move(closure));
  return true;
}

Joint reversed(const Joint& joint) {
  Joint out = joint;
  out.axis = -joint.axis;
  if (joint.type == JointType::universal) {
    out.axis = -joint.axis2;
    out.axis2 = -joint.axis;
    std::swap(out.dofs[0], out.dofs[1]);
  }
  return out;
}

std::optional<LoopType> loop_type_of(const Joint& joint) {
  switch (joint.type) {
    case JointType::fixed: return LoopType::weld;
    case JointType::revolute: return LoopType::revolute;
    case JointType::prismatic: return LoopType::prismatic;
    case JointType::spherical: return LoopType::ball;
    case JointType::universal: return std::fabs(dot(joint.axis, joint.axis2)) < 1e-9 ? std::optional(LoopType::universal) : std::nullopt;
    default: return std::nullopt;
  }
}

}  // namespace ugoki::robot_formats
