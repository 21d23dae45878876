#include "ugoki/robot_formats/mjcf_tree.h"

#include <algorithm>

#include "ugoki/robot_formats/mjcf_elements.h"

namespace ugoki::robot_formats {
namespace {

constexpr std::size_t max_bodies = formats::max_joints;
constexpr long max_steps = 2'000'000;  // limit for visited elements and copies, which nested <replicate> and <attach> could multiply
                                       // without bound

/// Context in which an element is read: its model, name prefix and suffix, and the frame and body that contain it.
struct Scope {
  MjcfSource* source = nullptr;
  std::string prefix, suffix, childclass;
  std::size_t body = 0;
  Pose X_BF;  ///< pose, in the body, of the frame to which the element's coordinates refer
  int depth = 0;
  bool copied = false;  ///< the element is inside a <replicate>
};

class TreeReader {
 public:
  explicit TreeReader(const MjcfFiles& files) : files_(files) {}

  MjcfTree run(MjcfSource& source) {
    MjcfBody world;
    world.name = "world";
    world.source = &source;
    tree_.bodies.push_back(world);
    tree_.body_named.emplace("world", 0);
    for (const MjcfElement& section : source.document().sections("worldbody")) reserve_names(source, section, 0);
    Scope scope;
    scope.source = &source;
    tree_.parts.push_back({&source, "", "", false, false});
    for (const MjcfElement& section : source.document().sections("worldbody")) read_children(section, scope);
    for (std::size_t i = 1; i < tree_.bodies.size(); ++i)
      tree_.bodies[i].X_WB = tree_.bodies[static_cast<std::size_t>(tree_.bodies[i].parent)].X_WB * tree_.bodies[i].X_PB;
    return std::move(tree_);
  }

 private:
  /// Counts one visited element. Returns false if reading should stop: too many elements or too many problems.
  bool step(const MjcfElement& at) {
    if (steps_ == max_steps || tree_.bodies.size() > max_bodies) {
      if (!stopped_)
        at.problem(ErrorCode::range, "The model has more than 10,000 bodies or 2,000,000 elements, copies included.", "Make fewer copies.");
      stopped_ = true;
    }
    ++steps_;
    return !stopped_ && !files_.full();
  }

  /// Collects the names given in the file, so that generated names differ from them.
  void reserve_names(const MjcfSource& source, const MjcfElement& element, int depth) {
    if (depth > static_cast<int>(formats::max_depth)) return;
    for (const MjcfElement& e : source.document().children(element)) {
      if (e.kind() == "body" && e.has("name")) given_.emplace(e.text("name"), 0);
      if (e.kind() == "body" || e.kind() == "frame" || e.kind() == "replicate") reserve_names(source, e, depth + 1);
    }
  }

  [[nodiscard]] std::string class_in(const MjcfElement& e, const Scope& scope) const {
    if (!e.has("childclass")) return scope.childclass;
    std::string name = e.text("childclass");
    if (scope.source->defaults().knows(name)) return name;
    e.problem(ErrorCode::unknown, "No default class is named " + formats::in_quotes(name) + ".", "Correct the name, or add the class.");
    return scope.childclass;
  }

  /// Returns the name of an element with prefix and suffix; empty if it has no name. @param kind "body", "joint" or "site"
  [[nodiscard]] std::string full_name(const MjcfElement& e, const Scope& scope, const char* kind) {
    std::string name = e.text("name");
    if (name.empty()) return name;
    name.insert(0, scope.prefix);
    if (scope.copied) tree_.copies[std::string(kind) + " " + name].push_back(scope.suffix);
    return name + scope.suffix;
  }

  void read_children(const MjcfElement& parent, const Scope& scope) {
    if (scope.depth > static_cast<int>(formats::max_depth))
      return parent.problem(ErrorCode::range, "Bodies and frames are nested deeper than 1000 levels.", "Use fewer levels.");
    for (const MjcfElement& e : scope.source->document().children(parent)) {
      if (!step(e)) return;
      read_child(e, scope);
    }
  }

  void read_child(const MjcfElement& e, const Scope& scope) {
    const std::string_view kind = e.kind();
    if (kind == "body") return read_body(e, scope);
    if (kind == "joint" || kind == "freejoint") return read_joint(e, scope);
    if (kind == "geom") {
      const MjcfAttributes a = scope.source->defaults().attributes(e, scope.childclass);
      tree_.bodies[scope.body].geoms.push_back(read_mjcf_geom(*scope.source, a, scope.X_BF));
    } else if (kind == "inertial") {
      read_inertial(e, scope);
    } else if (kind == "site") {
      read_site(e, scope);
    } else if (kind == "frame") {
      Scope inside = scope;
      inside.childclass = class_in(e, scope);
      inside.X_BF = scope.X_BF * scope.source->pose(MjcfAttributes(e));
      ++inside.depth;
      read_children(e, inside);
    } else if (kind == "replicate") {
      read_replicate(e, scope);
    } else if (kind == "attach") {
      read_attach(e, scope);
    } else if (kind == "composite" || kind == "flexcomp") {
      e.note("<" + std::string(kind) + ">, a deformable body or a set of particles, is left out.");
      tree_.deformables_left_out = true;
    } else if (kind == "plugin") {
      e.note("A plugin is left out.");
    } else if (kind != "camera" && kind != "light") {
      e.note("<" + std::string(kind.substr(0, 40)) + "> is not read.");
    }
  }

  void read_body(const MjcfElement& e, const Scope& scope) {
    const MjcfAttributes a(e);
    MjcfBody body;
    body.element = e;
    body.source = scope.source;
    body.parent = static_cast<int>(scope.body);
    body.X_PB = scope.X_BF * scope.source->pose(a);
    body.mocap = a.flag("mocap", false);
    body.name = full_name(e, scope, "body");
    if (body.name.empty()) {
      body.name = "body_" + std::to_string(tree_.bodies.size());
      while (tree_.body_named.contains(body.name) || given_.contains(body.name)) body.name += "_";
    }
    if (!tree_.body_named.emplace(body.name, tree_.bodies.size()).second)
      e.problem(ErrorCode::duplicate, "Two bodies are named " + formats::in_quotes(body.name) + ".", "Rename one of them.");
    if (a.number("gravcomp", 0) != 0) e.note("Gravity compensation (gravcomp) is left out.");
    tree_.bodies.push_back(std::move(body));
    Scope inside = scope;
    inside.childclass = class_in(e, scope);
    inside.body = tree_.bodies.size() - 1;
    inside.X_BF = {};
    ++inside.depth;
    read_children(e, inside);
  }

  void read_joint(const MjcfElement& e, const Scope& scope) {
    if (scope.body == 0) return e.problem(ErrorCode::structure, "The world has a joint.", "Move the joint into a body.");
    const MjcfAttributes a = e.kind() == "freejoint" ? MjcfAttributes(e) : scope.source->defaults().attributes(e, scope.childclass);
    MjcfJoint joint = read_mjcf_joint(*scope.source, a, scope.X_BF);
    joint.name = full_name(e, scope, "joint");
    std::vector<MjcfJoint>& joints = tree_.bodies[scope.body].joints;
    const bool free = joint.type == MjcfJointType::free || (!joints.empty() && joints[0].type == MjcfJointType::free);
    if (free && tree_.bodies[scope.body].parent != 0)
      e.problem(ErrorCode::structure, "A free joint is in a body whose parent is another body.", "Move the body to <worldbody>.");
    if (free && !joints.empty()) e.problem(ErrorCode::structure, "A body has a free joint and another joint.", "Keep the free joint only.");
    if (!joint.name.empty() && !tree_.joint_named.emplace(joint.name, MjcfTree::JointIndex{scope.body, joints.size()}).second)
      e.problem(ErrorCode::duplicate, "Two joints are named " + formats::in_quotes(joint.name) + ".", "Rename one of them.");
    joints.push_back(std::move(joint));
  }

  void read_inertial(const MjcfElement& e, const Scope& scope) {
    MjcfBody& body = tree_.bodies[scope.body];
    if (scope.body == 0)
      e.problem(ErrorCode::structure, "The world has an <inertial>.", "Move it into a body.");
    else if (body.inertial)
      e.problem(ErrorCode::duplicate, "A body has two <inertial> elements.", "Keep one.");
    else
      body.inertial = e;
  }

  void read_site(const MjcfElement& e, const Scope& scope) {
    const MjcfAttributes a = scope.source->defaults().attributes(e, scope.childclass);
    const auto type = static_cast<MjcfGeomType>(a.keyword("type", {"plane", "hfield", "sphere", "capsule", "ellipsoid", "cylinder", "box"},
                                                          static_cast<int>(MjcfGeomType::sphere)));
    Vec3 size;
    const Pose X_BS = scope.X_BF * read_mjcf_placement(*scope.source, a, type, size);
    const std::string name = full_name(e, scope, "site");
    if (!name.empty() && !tree_.site_named.emplace(name, MjcfSite{static_cast<int>(scope.body), X_BS}).second)
      e.problem(ErrorCode::duplicate, "Two sites are named " + formats::in_quotes(name) + ".", "Rename one of them.");
  }

  void read_replicate(const MjcfElement& e, const Scope& scope) {
    const MjcfAttributes a(e);
    if (!a.has("count")) return e.problem(ErrorCode::syntax, "<replicate> has no count.", "Add count=\"...\".");
    const int count = a.integer("count", 0, 1, 1'000'000);
    const Vec3 offset = a.vec3("offset", {}), euler = a.vec3("euler", {});
    const std::string separator = a.text("sep");
    const std::size_t digits = std::to_string(count).size();
    Pose X;
    for (int i = 0; i < count && step(e); ++i) {
      X.R = scope.source->from_euler_angles(euler * i);
      std::string number = std::to_string(i);
      number.insert(0, digits - number.size(), '0');
      Scope inside = scope;
      inside.suffix = separator + number + scope.suffix;
      inside.childclass = class_in(e, scope);
      inside.X_BF = scope.X_BF * X;
      inside.copied = true;
      ++inside.depth;
      read_children(e, inside);
      X.p += X.R * offset;
    }
  }

  void read_attach(const MjcfElement& e, const Scope& scope) {
    MjcfSource* const model = scope.source->model(e.text("model"));
    if (!model)
      return e.problem(ErrorCode::unknown, "No model is named " + formats::in_quotes(e.text("model")) + ".",
                       "Use the name of a <model> in <asset>.");
    Scope inside;
    inside.source = model;
    inside.prefix = scope.prefix + e.text("prefix");
    inside.suffix = scope.suffix;
    inside.body = scope.body;
    inside.X_BF = scope.X_BF;
    inside.depth = scope.depth + 1;
    tree_.parts.push_back({model, inside.prefix, inside.suffix, true, false});
    const std::string body = e.text("body");
    if (body.empty()) {
      for (const MjcfElement& section : model->document().sections("worldbody")) read_children(section, inside);
      return;
    }
    for (const MjcfElement& section : model->document().sections("worldbody"))
      if (attach_body(section, body, inside)) return;
    e.problem(ErrorCode::unknown, "The model has no body named " + formats::in_quotes(body) + ".", "Use the name of one of its bodies.");
  }

  /// Reads the body `name` below `parent`, with the childclass of the elements that contain it. Returns false if there is no such body.
  bool attach_body(const MjcfElement& parent, const std::string& name, Scope scope) {
    if (++scope.depth > static_cast<int>(formats::max_depth) || !step(parent)) return false;
    for (const MjcfElement& e : scope.source->document().children(parent)) {
      if (e.kind() != "body" && e.kind() != "frame") continue;
      if (e.kind() == "body" && e.text("name") == name) {
        read_body(e, scope);
        return true;
      }
      Scope inside = scope;
      inside.childclass = class_in(e, scope);
      if (attach_body(e, name, inside)) return true;
    }
    return false;
  }

  const MjcfFiles& files_;
  MjcfTree tree_;
  std::map<std::string, int, std::less<>> given_;
  long steps_ = 0;
  bool stopped_ = false;
};

}  // namespace

MjcfTree read_mjcf_tree(MjcfSource& source, const MjcfFiles& files) { return TreeReader(files).run(source); }

}  // namespace ugoki::robot_formats
