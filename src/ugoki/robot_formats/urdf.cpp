#include "ugoki/robot_formats/urdf.h"

#include <cmath>
#include <map>

#include "ugoki/robot_formats/loops_yaml.h"
#include "ugoki/robot_formats/robot_draft.h"
#include "ugoki/robot_formats/urdf_shapes.h"

namespace ugoki::robot_formats {
namespace {

using formats::in_quotes;

/// A `<joint>` element whose two links exist.
struct UrdfJoint {
  pugi::xml_node node;
  std::string name;
  int child = -1;  ///< index of the draft link
};

class UrdfReader {
 public:
  UrdfReader(XmlFields& xml, std::string_view file_name, const RobotOptions& options)
      : xml_(xml), options_(options), draft_(xml, options), assets_(options.read_asset, file_name) {}

  Result<RobotModel> read() {
    const pugi::xml_node robot = xml_.root();
    if (std::string_view(robot.name()) != "robot") {
      xml_.problem(robot, ErrorCode::syntax, "The outermost element is <" + std::string(robot.name()) + ">, not <robot>.",
                   "Give a URDF file; a xacro file must be expanded first.");
      return fail(xml_.take_problems());
    }
    if (const pugi::xml_node macro = robot.find_node([](pugi::xml_node n) { return std::string_view(n.name()).starts_with("xacro:"); })) {
      xml_.problem(macro, ErrorCode::unsupported,
                   "The file contains xacro macros (here <" + std::string(macro.name()) + ">) that are not yet expanded.",
                   "Expand it: xacro FILE.xacro > FILE.urdf.");
      return fail(xml_.take_problems());
    }
    draft_.spec.name = xml_.text(xml_.attribute(robot, "name"));
    xml_.note_unread(robot, {"link", "joint", "material"});
    for (const pugi::xml_node node : robot.children("link"))
      if (!xml_.full()) read_link(node);
    for (const pugi::xml_node node : robot.children("joint"))
      if (!xml_.full()) read_joint(node);
    if (!xml_.failed()) {
      find_base();
      for (const UrdfJoint& joint : joints_) read_mimic(joint);
      for (int i = 0; i < static_cast<int>(draft_.links.size()); ++i) read_shapes(i);
      split_planar_joints();
      if (options_.loops)
        if (Error wrong = read_loops(*options_.loops); !wrong.empty()) return fail(std::move(wrong));
    }
    Result<RobotModel> model = draft_.finish();
    if (model) model->meshes = assets_.take_meshes();
    return model;
  }

 private:
  void read_link(pugi::xml_node node) {
    xml_.note_unread(node, {"inertial", "visual", "collision"});
    LinkSpec link;
    link.name = xml_.required_text(xml_.attribute(node, "name"));
    link.inertia = read_inertia(node);
    if (!link.name.empty()) (void)draft_.add_link(std::move(link), {.node = node});
  }

  Inertia read_inertia(pugi::xml_node link) {
    const pugi::xml_node inertial = link.child("inertial");
    if (!inertial) return {};
    if (const pugi::xml_node second = inertial.next_sibling("inertial"))
      xml_.problem(second, ErrorCode::duplicate, "The link has two <inertial> elements.", "Remove one of them.");
    if (!inertial.child("mass"))
      xml_.problem(inertial, ErrorCode::syntax, "The <mass> of an <inertial> is missing.", "Add <mass value=\"...\"/> in kg.");
    else
      (void)xml_.required_text(xml_.attribute(inertial.child("mass"), "value"));
    const double mass = xml_.number(xml_.attribute(inertial.child("mass"), "value"), 0, not_negative);
    const pugi::xml_node moments = inertial.child("inertia");
    const auto moment = [&](const char* name) { return xml_.number(xml_.attribute(moments, name), 0); };
    const Sym3 I{moment("ixx"), moment("iyy"), moment("izz"), moment("ixy"), moment("ixz"), moment("iyz")};
    const Pose X = urdf_origin(xml_, inertial);
    return Inertia::from_centre(mass, X.p, rotated(I, X.R));
  }

  /// Returns the index of the link that the joint's child element `end` names. If there is none, adds a problem and returns -1.
  int end_of(pugi::xml_node joint, const char* end) {
    const XmlField field = xml_.attribute(joint.child(end), "link");
    const std::string name = xml_.text(field);
    if (name.empty()) {
      xml_.problem(joint, ErrorCode::syntax, xml_.title(joint) + " has no <" + end + " link=...>.", "Add the element.");
      return -1;
    }
    const int link = draft_.find_link(name);
    if (link < 0)
      xml_.problem(xml_.line(field), ErrorCode::unknown,
                   "The " + std::string(end) + " link " + in_quotes(name) + " of " + xml_.title(joint) + " does not exist.",
                   "Name an existing link.");
    return link;
  }

  void read_joint(pugi::xml_node node) {
    xml_.note_unread(node, {"origin", "parent", "child", "axis", "limit", "dynamics", "mimic", "calibration", "safety_controller"});
    const std::string name = xml_.required_text(xml_.attribute(node, "name"));
    const Joint joint = read_motion(node);
    const int parent = end_of(node, "parent"), child = end_of(node, "child");
    if (name.empty() || parent < 0 || child < 0) return;
    if (const auto [it, is_new] = joint_index_.emplace(name, joints_.size()); !is_new) {
      xml_.problem(node, ErrorCode::duplicate, "Two joints are named " + in_quotes(name) + ".", "Rename one of them.");
      return;
    }
    DraftLink& draft = draft_.draft(child);
    LinkSpec& link = draft_.link(child);
    if (!draft.joint.empty()) {
      xml_.problem(node, ErrorCode::structure,
                   "The link " + in_quotes(link.name) + " is already the child of the joint " + in_quotes(draft.joint) + ".",
                   "Remove one of the two joints and define it as a loop in a YAML file with the same base name.");
      return;
    }
    draft.joint = name;
    link.joint = joint;
    link.parent = draft_.link(parent).name;
    joints_.push_back({node, name, child});
  }

  /// Reads type, axis and DOF properties of a joint.
  Joint read_motion(pugi::xml_node node) {
    static const std::map<std::string_view, JointType> types = {{"fixed", JointType::fixed},         {"revolute", JointType::revolute},
                                                                {"continuous", JointType::revolute}, {"prismatic", JointType::prismatic},
                                                                {"planar", JointType::planar},       {"floating", JointType::floating},
                                                                {"spherical", JointType::spherical}};
    Joint joint;
    joint.X_PJ = urdf_origin(xml_, node);
    const XmlField type = xml_.attribute(node, "type");
    const auto it = types.find(type.text);
    if (it == types.end()) {
      xml_.problem(type, ErrorCode::unsupported, ": " + in_quotes(type.text) + " is not a joint type.",
                   "Use fixed, revolute, continuous, prismatic, planar, floating or spherical.");
      return joint;
    }
    joint.type = it->second;
    const bool uses_axis = joint.type == JointType::revolute || joint.type == JointType::prismatic || joint.type == JointType::planar;
    if (uses_axis) joint.axis = xml_.direction(xml_.attribute(node.child("axis"), "xyz"), {1, 0, 0});
    const pugi::xml_node limit = node.child("limit"), dynamics = node.child("dynamics");
    Dof f;
    f.damping = xml_.number(xml_.attribute(dynamics, "damping"), 0, not_negative);
    f.friction = xml_.number(xml_.attribute(dynamics, "friction"), 0, not_negative);
    f.effort = xml_.limit(xml_.attribute(limit, "effort"), f.effort);
    if (!(f.effort >= 0))
      xml_.problem(xml_.attribute(limit, "effort"), ErrorCode::range, " is negative.", "Give the maximum torque or force.");
    if (limit.attribute("velocity")) xml_.note("Maximum velocities of joints are not used.");
    if (type.text == "revolute" || type.text == "prismatic") read_range(node, limit, f);
    for (int i = 0; i < joint.nv(); ++i) joint.dofs[static_cast<std::size_t>(i)] = f;
    return joint;
  }

  void read_range(pugi::xml_node joint, pugi::xml_node limit, Dof& f) {
    const XmlField lower = xml_.attribute(limit, "lower"), upper = xml_.attribute(limit, "upper");
    if (!lower.present && !upper.present) {
      xml_.note(joint, limit ? "A <limit> without lower and upper does not limit the position of the joint."
                             : "A joint without <limit> has no position limits.");
      return;
    }
    f.lower = xml_.limit(lower, 0);
    f.upper = xml_.limit(upper, 0);
    if (f.lower > f.upper)
      xml_.problem(limit, ErrorCode::range, "The lower limit of " + xml_.title(joint) + " is greater than the upper limit.",
                   "Swap or correct the limits.");
  }

  /// Marks the link without a parent joint as the base. Adds a problem if there are several such links, because a URDF has one base.
  void find_base() {
    int base = -1;
    for (int i = 0; i < static_cast<int>(draft_.links.size()); ++i) {
      if (!draft_.link(i).parent.empty()) continue;
      draft_.draft(i).base_open = true;
      if (base >= 0)
        xml_.problem(
            draft_.draft(i).node, ErrorCode::structure,
            "The links " + in_quotes(draft_.link(base).name) + " and " + in_quotes(draft_.link(i).name) + " both have no parent joint.",
            "Connect them by a joint: a URDF has one base.");
      if (base < 0) base = i;
    }
  }

  void read_mimic(const UrdfJoint& joint) {
    const pugi::xml_node mimic = joint.node.child("mimic");
    if (!mimic) return;
    const std::string of = xml_.required_text(xml_.attribute(mimic, "joint"));
    const auto it = joint_index_.find(of);
    const double factor = xml_.number(xml_.attribute(mimic, "multiplier"), 1), offset = xml_.number(xml_.attribute(mimic, "offset"), 0);
    if (it == joint_index_.end()) {
      if (!of.empty())
        xml_.problem(mimic, ErrorCode::unknown, "The joint " + in_quotes(of) + " that " + in_quotes(joint.name) + " mimics does not exist.",
                     "Name an existing joint.");
      return;
    }
    const LinkSpec& a = draft_.link(joint.child);
    const LinkSpec& b = draft_.link(joints_[it->second].child);
    if (a.joint.nv() != 1 || b.joint.nv() != 1 || a.name == b.name) {
      xml_.problem(
          mimic, ErrorCode::structure,
          in_quotes(joint.name) + " mimics " + in_quotes(of) + ", but they are not two different joints with one degree of freedom each.",
          "Correct or remove <mimic>.");
      return;
    }
    draft_.spec.loops.push_back({.name = "mimic " + joint.name,
                                 .type = LoopType::gear,
                                 .link_a = a.name,
                                 .link_b = b.name,
                                 .polynomial = {offset, factor, 0, 0, 0}});
  }

  void read_shapes(int i) {
    LinkSpec& link = draft_.link(i);
    link.shapes = read_urdf_shapes(xml_, draft_.draft(i).node, options_, assets_);
  }

  /// Ugoki's planar joint moves in the x-y plane of the joint frame. If the axis is not z, inserts a massless link with z along the axis.
  void split_planar_joints() {
    const int count = static_cast<int>(draft_.links.size());
    for (int i = 0; i < count; ++i) {
      const Joint joint = draft_.link(i).joint;
      if (joint.type != JointType::planar || norm(joint.axis - Vec3{0, 0, 1}) < 1e-12) continue;
      const Mat3 R = to_matrix(rotation_between({0, 0, 1}, joint.axis));
      LinkSpec between;
      between.name = draft_.link(i).name + " plane";
      between.parent = draft_.link(i).parent;
      between.joint = joint;
      between.joint.X_PJ.R = joint.X_PJ.R * R;
      DraftLink draft{.node = draft_.draft(i).node, .joint = std::move(draft_.draft(i).joint)};
      draft_.draft(i).joint.clear();
      draft_.link(i).parent = between.name;
      draft_.link(i).joint = {};
      draft_.link(i).joint.X_PJ.R = R.transposed();
      (void)draft_.add_link(std::move(between), std::move(draft));
    }
  }

  /// Applies the loops file and returns its problems.
  Error read_loops(const SideFile& file) {
    const Result<LoopsYaml> yaml = read_loops_yaml(file);
    if (!yaml) return yaml.error();
    for (const std::string& note : yaml->notes) xml_.note(note);
    const auto find_joint = [this](std::string_view name) -> std::optional<int> {
      const auto it = joint_index_.find(name);
      return it == joint_index_.end() ? std::nullopt : std::optional(joints_[it->second].child);
    };
    const auto find_frame = [&](std::string_view name) -> std::optional<LoopEnd> {
      if (const int link = draft_.find_link(name); link >= 0) return LoopEnd{link, {}};
      const std::optional<int> joint = find_joint(name);
      return joint ? std::optional(LoopEnd{*joint, {}}) : std::nullopt;
    };
    return apply_loops(*yaml, file, find_frame, find_joint, draft_);
  }

  XmlFields& xml_;
  const RobotOptions& options_;
  RobotDraft draft_;
  Assets assets_;
  std::vector<UrdfJoint> joints_;
  std::map<std::string, std::size_t, std::less<>> joint_index_;
};

}  // namespace

Result<RobotModel> read_urdf(std::string_view text, std::string_view file_name, const RobotOptions& options) {
  XmlFields xml(file_name, "URDF");
  if (!xml.parse(text)) return fail(xml.take_problems());
  return UrdfReader(xml, file_name, options).read();
}

}  // namespace ugoki::robot_formats
