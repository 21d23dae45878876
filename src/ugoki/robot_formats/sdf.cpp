#include "ugoki/robot_formats/sdf.h"

#include <algorithm>
#include <map>
#include <queue>
#include <set>
#include <tuple>

#include "ugoki/base/number.h"
#include "ugoki/robot_formats/loops_yaml.h"
#include "ugoki/robot_formats/robot_draft.h"
#include "ugoki/robot_formats/sdf_joints.h"
#include "ugoki/robot_formats/sdf_links.h"

namespace ugoki::robot_formats {
namespace {

using formats::in_quotes;

constexpr int max_nesting = 50;  // limit for models inside models; bounds the recursion of collect()

class SdfReader {
 public:
  SdfReader(XmlFields& xml, std::string_view file_name, const RobotOptions& options)
      : xml_(xml), options_(options), draft_(xml, options), assets_(options.read_asset, file_name) {}

  Result<RobotModel> read() {
    const pugi::xml_node model = find_model();
    if (!model) return fail(xml_.take_problems());
    draft_.spec.name = xml_.text(xml_.attribute(model, "name"));
    SdfFrames frames(xml_, version_);
    frames_ = &frames;
    frames.add({.name = "__model__",
                .kind = SdfFrameKind::model,
                .node = model,
                .relative_to = "world",
                .attached_to = canonical_link(model),
                .X = frames.pose(model)});
    collect(model, "", 0);
    if (!xml_.failed()) frames.resolve();
    if (!xml_.failed()) read_parts();
    if (xml_.failed()) return fail(xml_.take_problems());
    build_tree(xml_.flag(xml_.element(model, "static"), false));
    for (int i = 0; i < draft_count(); ++i) read_link(i);
    make_loops();
    if (options_.loops && !xml_.failed())
      if (Error wrong = read_yaml(*options_.loops); !wrong.empty()) return fail(std::move(wrong));
    Result<RobotModel> robot = draft_.finish();
    if (robot) robot->meshes = assets_.take_meshes();
    return robot;
  }

 private:
  /// A joint by which the tree can grow: it leads from a link in the tree to a link that may still be outside. Candidates are ordered by
  /// number of DOFs, then depth in the tree, then position in the file.
  struct Candidate {
    int dofs, depth, joint;
    bool operator>(const Candidate& o) const { return std::tie(dofs, depth, joint) > std::tie(o.dofs, o.depth, o.joint); }
  };

  pugi::xml_node find_model() {
    const pugi::xml_node sdf = xml_.root();
    if (std::string_view(sdf.name()) != "sdf") {
      xml_.problem(sdf, ErrorCode::syntax, "The outermost element is <" + std::string(sdf.name()) + ">, not <sdf>.", "Give an SDF file.");
      return {};
    }
    const XmlField version = xml_.attribute(sdf, "version");
    const std::size_t dot = version.text.find('.');
    const std::optional<long> major = parse_long(version.text.substr(0, dot));
    const std::optional<long> minor = dot == std::string_view::npos ? std::optional<long>(0) : parse_long(version.text.substr(dot + 1));
    if (!major || !minor || *major != 1 || *minor < 4 || *minor > 99) {
      xml_.problem(version, ErrorCode::unsupported, ": " + in_quotes(version.text) + " is not a version that can be read.",
                   "Use SDF 1.4 to 1.9.");
      return {};
    }
    version_ = static_cast<int>(100 + *minor);
    if (version_ > 109) xml_.note("Elements that were added after SDF 1.9 are not read.");
    std::vector<pugi::xml_node> models;
    for (const pugi::xml_node parent : {sdf, sdf.child("world")})
      for (const pugi::xml_node model : parent.children("model")) models.push_back(model);
    if (models.empty()) {
      xml_.problem(sdf, ErrorCode::structure, "The file has no <model>.",
                   "Use a file that contains the model; <include> is not supported.");
      return {};
    }
    const auto movable =
        std::find_if(models.begin(), models.end(), [this](pugi::xml_node m) { return !xml_.flag(xml_.element(m, "static"), false); });
    const pugi::xml_node chosen = movable == models.end() ? models.front() : *movable;
    for (const pugi::xml_node model : models)
      if (model != chosen) xml_.note(model, "Only " + xml_.title(chosen) + " is read; the other models of the file are left out.");
    return chosen;
  }

  /// Name of the link that the model's own frame belongs to: its canonical_link, or its first link; empty if the model has no link.
  std::string canonical_link(pugi::xml_node model) {
    if (const XmlField named = xml_.attribute(model, "canonical_link"); !named.text.empty()) return xml_.text(named);
    if (const pugi::xml_node link = model.child("link")) return xml_.text(xml_.attribute(link, "name"));
    if (const pugi::xml_node inner = model.child("model")) return xml_.text(xml_.attribute(inner, "name"));
    return {};
  }

  /// Adds the frames of a model: its links, joints, frames and nested models.
  void collect(pugi::xml_node model, const std::string& scope, int depth) {
    if (depth > max_nesting) {
      xml_.problem(model, ErrorCode::range, "Models are nested deeper than 50 levels.", "Use fewer levels.");
      return;
    }
    for (const pugi::xml_node node : model.children()) {
      const std::string_view kind = node.name();
      if (xml_.full()) return;
      if (kind == "include") {
        xml_.problem(node, ErrorCode::unsupported, "<include> is not supported.", "Copy the included model into this file.");
        continue;
      }
      if (kind == "drake:joint") {
        xml_.problem(node, ErrorCode::unsupported, "<drake:joint> is not supported.", "Use a <joint>.");
        continue;
      }
      if (kind != "link" && kind != "joint" && kind != "frame" && kind != "model") continue;
      const std::string name = xml_.required_text(xml_.attribute(node, "name"));
      if (name.empty()) continue;
      if (name == "world" || name.starts_with("__") || name.find("::") != std::string::npos) {
        xml_.problem(node, ErrorCode::structure, "The name " + in_quotes(name) + " is reserved.", "Use another name.");
        continue;
      }
      SdfFrame frame{.name = scope + name, .scope = scope, .node = node, .X = frames_->pose(node)};
      if (kind == "link") {
        frame.kind = SdfFrameKind::link;
        frame.relative_to = frames_->relative_to(node, "__model__");
      } else if (kind == "joint") {
        frame.kind = SdfFrameKind::joint;
        frame.attached_to = xml_.text(xml_.element(node, "child"));
        frame.relative_to = frames_->relative_to(node, frame.attached_to);
      } else if (kind == "frame") {
        frame.attached_to = xml_.text(xml_.attribute(node, "attached_to"));
        if (frame.attached_to.empty()) frame.attached_to = "__model__";
        frame.relative_to = frames_->relative_to(node, frame.attached_to);
      } else {
        if (!xml_.attribute(node, "placement_frame").text.empty())
          xml_.problem(node, ErrorCode::unsupported, "'placement_frame' is not supported.", "Give the pose of the model's own frame.");
        frame.kind = SdfFrameKind::model;
        frame.relative_to = frames_->relative_to(node, "__model__");
        if (const std::string link = canonical_link(node); !link.empty()) frame.attached_to = name + "::" + link;
      }
      frames_->add(std::move(frame));
      if (kind == "model") collect(node, scope + name + "::", depth + 1);
    }
  }

  /// Reads links, joints and closures; call it after all frames are resolved.
  void read_parts() {
    const int count = frames_->count();
    draft_of_.assign(static_cast<std::size_t>(count), -1);
    for (int i = 0; i < count && !xml_.full(); ++i) {
      const SdfFrame& frame = frames_->at(i);
      if (frame.kind == SdfFrameKind::link) {
        LinkSpec link;
        link.name = frame.name;
        draft_of_[static_cast<std::size_t>(i)] = draft_.add_link(std::move(link), {.node = frame.node});
        frame_of_.push_back(i);
      } else if (frame.kind == SdfFrameKind::joint) {
        read_sdf_joint(xml_, *frames_, version_, i, graph_);
      } else if (frame.kind == SdfFrameKind::model) {
        xml_.note_unread(frame.node, {"link", "joint", "frame", "model", "pose", "static", "self_collide", "allow_auto_disable",
                                      "enable_wind", "drake:weld_constraint", "drake:ball_constraint", "drake:linear_bushing_rpy"});
        for (const pugi::xml_node node : frame.node.children())
          (void)read_sdf_closure(xml_, *frames_, frame.scope + (i == 1 ? "" : last_part(frame.name) + "::"), node, graph_);
      }
    }
  }

  /// The last component of a scoped name: "hand" for "arm::hand".
  static std::string last_part(const std::string& name) {
    const std::size_t at = name.rfind("::");
    return at == std::string::npos ? name : name.substr(at + 2);
  }

  [[nodiscard]] int draft_count() const { return static_cast<int>(draft_.links.size()); }
  [[nodiscard]] int draft_link(int frame) const { return frame < 0 ? -1 : draft_of_[static_cast<std::size_t>(frame)]; }

  /// Builds the spanning tree from the world, then from the first link of each set of links that is not connected to the world. The tree
  /// grows along the candidate joint with the fewest DOFs, then the smallest depth, then the first in the file (Prim's algorithm: minimum
  /// total number of DOFs). The other joints close loops. Screw joints have priority for the tree, because no loop type can replace them.
  void build_tree(bool is_static) {
    const auto n = static_cast<std::size_t>(draft_count());
    std::vector<std::vector<int>> at_link(n + 1);  // [links + 1] indices of the joints at each link; the last entry is for the world
    const auto slot = [n](int link) { return link < 0 ? n : static_cast<std::size_t>(link); };
    for (int j = 0; j < static_cast<int>(graph_.joints.size()); ++j) {
      const SdfJoint& joint = graph_.joints[static_cast<std::size_t>(j)];
      at_link[slot(draft_link(joint.parent))].push_back(j);
      at_link[slot(draft_link(joint.child))].push_back(j);
    }
    in_tree_.assign(graph_.joints.size(), false);
    std::vector<int> depth(n + 1, -1);
    std::priority_queue<Candidate, std::vector<Candidate>, std::greater<>> candidates;
    const auto reach = [&](int link, int at_depth) {
      depth[slot(link)] = at_depth;
      for (const int j : at_link[slot(link)]) {
        const Joint& motion = graph_.joints[static_cast<std::size_t>(j)].motion;
        candidates.push({motion.type == JointType::helical ? 0 : motion.nv(), at_depth, j});
      }
    };
    const auto grow = [&] {
      while (!candidates.empty()) {
        const Candidate next = candidates.top();
        candidates.pop();
        const SdfJoint& joint = graph_.joints[static_cast<std::size_t>(next.joint)];
        const int parent = draft_link(joint.parent), child = draft_link(joint.child);
        const bool to_child = depth[slot(child)] < 0, to_parent = depth[slot(parent)] < 0;
        if (!to_child && !to_parent) continue;
        add_tree_joint(joint, to_child);
        in_tree_[static_cast<std::size_t>(next.joint)] = true;
        if (joint.motion.type == JointType::revolute)
          turning_[{std::min(joint.parent, joint.child), std::max(joint.parent, joint.child)}] = static_cast<std::size_t>(next.joint);
        reach(to_child ? child : parent, next.depth + 1);
      }
    };
    reach(-1, 0);
    grow();
    for (int i = 0; i < static_cast<int>(n); ++i) {
      if (depth[static_cast<std::size_t>(i)] >= 0) continue;
      draft_.draft(i).base_open = !is_static;
      draft_.link(i).joint.X_PJ = frames_->at(frame_of_[static_cast<std::size_t>(i)]).X_W;
      if (is_static) xml_.note("The base " + draft_.link(i).name + " is fixed to the world, because the model is static.");
      reach(i, 0);
      grow();
    }
  }

  /// Adds one end of a joint to the tree: the child link below the parent link or, if the child is already in the tree, the parent link
  /// below the child link (reversed joint). In the mechanism, the frame of the added link is the joint's frame.
  void add_tree_joint(const SdfJoint& joint, bool to_child) {
    const int above = draft_link(to_child ? joint.parent : joint.child), below = draft_link(to_child ? joint.child : joint.parent);
    LinkSpec& link = draft_.link(below);
    link.joint = to_child ? joint.motion : reversed(joint.motion);
    link.joint.X_PJ = to_child ? joint.X_PJ : joint.X_CJ;
    if (above >= 0) {
      link.parent = draft_.link(above).name;
      link.joint.X_PJ = draft_.draft(above).X_BF * link.joint.X_PJ;
    }
    draft_.draft(below).X_BF = (to_child ? joint.X_CJ : joint.X_PJ).inverse();
    draft_.draft(below).joint = joint.name;
    link_of_joint_[joint.name] = below;
    if (!to_child) xml_.note(joint.node, "Some joints are reversed (from child to parent), because the tree grows from the base.");
  }

  void read_link(int i) {
    const int frame = frame_of_[static_cast<std::size_t>(i)];
    LinkSpec& link = draft_.link(i);
    const Pose X_BF = draft_.draft(i).X_BF;
    link.inertia = read_sdf_inertia(xml_, *frames_, frame).in_parent(X_BF);
    link.shapes = read_sdf_shapes(xml_, *frames_, frame, X_BF, options_, assets_);
  }

  void add_loop(pugi::xml_node node, const std::string& name, LoopSpec loop) {
    loop.name = name;
    if (!loop_names_.insert(name).second)
      xml_.problem(node, ErrorCode::duplicate, "Two loop closures are named " + in_quotes(name) + ".", "Rename one of them.");
    draft_.loop_joints.push_back({name, name});
    draft_.spec.loops.push_back(std::move(loop));
  }

  /// Returns a loop between the links with the frame indices a and b (-1: the world).
  /// @param X_AJ, X_BJ poses of the loop's two frames in the file's link frames
  LoopSpec between(LoopType type, int a, const Pose& X_AJ, int b, const Pose& X_BJ) {
    const int links[2] = {draft_link(a), draft_link(b)};
    LoopSpec loop{.type = type, .X_AJ = X_AJ, .X_BJ = X_BJ};
    if (links[0] >= 0) {
      loop.link_a = draft_.link(links[0]).name;
      loop.X_AJ = draft_.draft(links[0]).X_BF * X_AJ;
    }
    if (links[1] >= 0) {
      loop.link_b = draft_.link(links[1]).name;
      loop.X_BJ = draft_.draft(links[1]).X_BF * X_BJ;
    }
    return loop;
  }

  void make_loops() {
    for (std::size_t j = 0; j < graph_.joints.size() && !xml_.full(); ++j) {
      if (in_tree_[j]) continue;
      const SdfJoint& joint = graph_.joints[j];
      const std::optional<LoopType> type = loop_type_of(joint.motion);
      if (!type) {
        xml_.problem(joint.node, ErrorCode::unsupported,
                     xml_.title(joint.node) + " closes a loop, but this joint type is not supported there.",
                     "Close the loop with a fixed, revolute, prismatic or ball joint, or a universal joint with perpendicular axes.");
        continue;
      }
      LoopSpec loop = between(*type, joint.parent, joint.X_PJ, joint.child, joint.X_CJ);
      loop.axis = joint.motion.axis;
      loop.axis2 = joint.motion.axis2;
      add_loop(joint.node, joint.name, std::move(loop));
      xml_.note(joint.node, "Limits, damping and friction of joints that close a loop are left out.");
    }
    for (const SdfClosure& c : graph_.closures) add_loop(c.node, c.name, between(c.type, c.a, c.X_AJ, c.b, c.X_BJ));
    for (const SdfGearbox& gear : graph_.gearboxes) make_gear(gear);
    for (const SdfMimic& mimic : graph_.mimics) make_mimic(mimic);
  }

  /// Returns the link below the revolute tree joint between `link` and `reference`, and the sign of its rotation about `axis_W`. The
  /// link is -1 if there is no such joint.
  std::pair<int, double> turning(int link, int reference, const Vec3& axis_W) {
    const auto it = turning_.find({std::min(link, reference), std::max(link, reference)});
    if (it == turning_.end()) return {-1, 1};
    const SdfJoint& joint = graph_.joints[it->second];
    const Pose X_WJ = (joint.child < 0 ? Pose{} : frames_->at(joint.child).X_W) * joint.X_CJ;
    const double sense = dot(X_WJ.R * joint.motion.axis, axis_W) * (joint.child == link ? 1 : -1);
    return {link_of_joint_[joint.name], sense > 0 ? 1 : -1};
  }

  void make_gear(const SdfGearbox& gear) {
    const auto [a, sense_a] = turning(gear.child, gear.reference, gear.axis2_W);
    const auto [b, sense_b] = turning(gear.parent, gear.reference, gear.axis_W);
    if (a < 0 || b < 0) {
      xml_.problem(gear.node, ErrorCode::structure,
                   xml_.title(gear.node) + ": both links must be connected to the reference body by revolute joints.",
                   "Add the missing revolute joints, or correct <gearbox_reference_body>.");
      return;
    }
    // Definition in SDFormat: angle of the child = -ratio * angle of the parent.
    add_loop(gear.node, gear.name,
             {.type = LoopType::gear,
              .link_a = draft_.link(a).name,
              .link_b = draft_.link(b).name,
              .polynomial = {0, -gear.ratio * sense_a * sense_b, 0, 0, 0}});
  }

  void make_mimic(const SdfMimic& mimic) {
    const auto a = link_of_joint_.find(mimic.follower), b = link_of_joint_.find(mimic.leader);
    if (a == link_of_joint_.end() || b == link_of_joint_.end() || a->second == b->second || draft_.link(a->second).joint.nv() != 1 ||
        draft_.link(b->second).joint.nv() != 1) {
      xml_.problem(mimic.node, ErrorCode::structure,
                   in_quotes(mimic.follower) + " mimics " + in_quotes(mimic.leader) +
                       ", but they are not two different joints with one degree of freedom each that close no loop.",
                   "Correct or remove <mimic>.");
      return;
    }
    add_loop(mimic.node, "mimic " + mimic.follower,
             {.type = LoopType::gear,
              .link_a = draft_.link(a->second).name,
              .link_b = draft_.link(b->second).name,
              .polynomial = {mimic.offset - mimic.multiplier * mimic.reference, mimic.multiplier, 0, 0, 0}});
  }

  /// Applies the loops file and returns its problems.
  Error read_yaml(const SideFile& file) {
    const Result<LoopsYaml> yaml = read_loops_yaml(file);
    if (!yaml) return yaml.error();
    for (const std::string& note : yaml->notes) xml_.note(note);
    const auto find_joint = [this](std::string_view name) -> std::optional<int> {
      const auto it = link_of_joint_.find(name);
      return it == link_of_joint_.end() ? std::nullopt : std::optional(it->second);
    };
    const auto find_frame = [this](std::string_view name) -> std::optional<LoopEnd> {
      const int i = frames_->find("", name);
      if (i < 0) return std::nullopt;
      const int link = frames_->at(i).link;
      if (link < 0) return LoopEnd{-1, frames_->at(i).X_W};
      const int draft = draft_link(link);
      return LoopEnd{draft, draft_.draft(draft).X_BF * frames_->at(link).X_W.inverse() * frames_->at(i).X_W};
    };
    return apply_loops(*yaml, file, find_frame, find_joint, draft_);
  }

  XmlFields& xml_;
  const RobotOptions& options_;
  RobotDraft draft_;
  Assets assets_;
  int version_ = 109;
  SdfFrames* frames_ = nullptr;
  SdfJoints graph_;
  std::vector<bool> in_tree_;                              ///< [graph_.joints] true if the joint is part of the tree
  std::vector<int> draft_of_;                              ///< [frames] index of the draft link; -1: the frame is not a link
  std::vector<int> frame_of_;                              ///< [draft links] index of the frame
  std::map<std::string, int, std::less<>> link_of_joint_;  ///< draft link below each tree joint, by joint name
  std::map<std::pair<int, int>, std::size_t> turning_;  ///< revolute tree joints, by the frame indices of their two links (smaller first)
  std::set<std::string> loop_names_;
};

}  // namespace

Result<RobotModel> read_sdf(std::string_view text, std::string_view file_name, const RobotOptions& options) {
  XmlFields xml(file_name, "SDF");
  if (!xml.parse(text)) return fail(xml.take_problems());
  return SdfReader(xml, file_name, options).read();
}

}  // namespace ugoki::robot_formats
