#include "ugoki/robot_formats/loops_yaml.h"

#include <yaml-cpp/yaml.h>

#include "ugoki/formats/text.h"

namespace ugoki::robot_formats {
namespace {

using formats::in_quotes;

constexpr std::size_t max_yaml = std::size_t{4} << 20;  // bytes
constexpr std::size_t max_entries = 100'000;

int line_of(const YAML::Node& node) { return std::max(0, node.Mark().line) + 1; }

/// Parses the loops file. Its member functions may throw YAML::Exception, which read_loops_yaml catches.
class LoopsYamlReader {
 public:
  explicit LoopsYamlReader(const std::string& file_name) : problems_(file_name) {}

  Result<LoopsYaml> read(const std::string& text) {
    const YAML::Node root = YAML::Load(text);
    if (!root.IsMap()) {
      problems_.add(ErrorCode::structure, line_of(root), "The file is not a map of keys to values.",
                    "Write closed_loop: [[a, b]] and type: [6d].");
      return fail(problems_.take());
    }
    for (const auto& entry : root) read_key(entry.first, entry.second);
    if (types_.size() != out_.closures.size())
      problems_.add(ErrorCode::structure, 1,
                    "'closed_loop' has " + std::to_string(out_.closures.size()) + " pairs, but 'type' has " +
                        std::to_string(types_.size()) + " entries.",
                    "Give one type for each pair.");
    if (joint_types_.size() != out_.joints.size())
      problems_.add(ErrorCode::structure, 1,
                    "'joint_name' has " + std::to_string(out_.joints.size()) + " entries, but 'joint_type' has " +
                        std::to_string(joint_types_.size()) + ".",
                    "Give one type for each joint.");
    if (!problems_.empty()) return fail(problems_.take());
    for (std::size_t i = 0; i < types_.size(); ++i) out_.closures[i].type = types_[i];
    for (std::size_t i = 0; i < joint_types_.size(); ++i) set_type(out_.joints[i], joint_types_[i]);
    if (!problems_.empty()) return fail(problems_.take());
    return std::move(out_);
  }

 private:
  void read_key(const YAML::Node& key, const YAML::Node& value) {
    const std::string name = key.IsScalar() ? key.Scalar() : "";
    if (name == "closed_loop") {
      each(value, [this](const YAML::Node& pair) {
        if (pair.IsSequence() && pair.size() == 2)
          out_.closures.push_back({scalar(pair[0]), scalar(pair[1]), LoopType::weld, line_of(pair)});
        else
          problems_.add(ErrorCode::structure, line_of(pair), "A loop must be a pair of frames.", "Write [frame_a, frame_b].");
      });
    } else if (name == "type") {
      each(value, [this](const YAML::Node& type) { types_.push_back(loop_type(type)); });
    } else if (name == "name_mot") {
      each(value, [this](const YAML::Node& joint) { out_.driven.push_back({scalar(joint), line_of(joint)}); });
    } else if (name == "joint_name") {
      each(value, [this](const YAML::Node& joint) { out_.joints.push_back({.joint = scalar(joint), .line = line_of(joint)}); });
    } else if (name == "joint_type") {
      each(value, [this](const YAML::Node& type) { joint_types_.push_back(scalar(type)); });
    } else {
      out_.notes.push_back("The key " + in_quotes(name) + " of the loops file is not read (line " + std::to_string(line_of(key)) + ").");
    }
  }

  template <class F>
  void each(const YAML::Node& list, F&& use) {
    if (!list.IsSequence() || list.size() > max_entries) {
      problems_.add(ErrorCode::structure, line_of(list),
                    list.IsSequence() ? "The list has more than 100,000 entries." : "A list is missing here.",
                    "Write [a, b, ...] with at most 100,000 entries.");
      return;
    }
    for (const auto& item : list) use(item);
  }

  std::string scalar(const YAML::Node& node) {
    if (node.IsScalar() && !node.Scalar().empty()) return formats::utf8(node.Scalar());
    problems_.add(ErrorCode::syntax, line_of(node), "A name is missing here.", "Write a name.");
    return {};
  }

  LoopType loop_type(const YAML::Node& node) {
    const std::string name = scalar(node);
    if (name == "6d" || name == "6D") return LoopType::weld;
    if (name == "3d" || name == "3D") return LoopType::ball;
    const std::optional<LoopType> type = loop_type_named(name);
    if (type && *type != LoopType::gear && *type != LoopType::distance) return *type;
    problems_.add(ErrorCode::unsupported, line_of(node), in_quotes(name) + " is not a loop type.",
                  "Use 6d, 3d, weld, ball, revolute, prismatic, cylindrical, planar or universal.");
    return LoopType::weld;
  }

  void set_type(LoopsYaml::JointChange& joint, const std::string& type) {
    const auto axis = [](char c) { return Vec3{c == 'X' ? 1.0 : 0.0, c == 'Y' ? 1.0 : 0.0, c == 'Z' ? 1.0 : 0.0}; };
    const auto is_axis = [](char c) { return c >= 'X' && c <= 'Z'; };
    if (type == "SPHERICAL") {
      joint.type = JointType::spherical;
    } else if (type.size() == 9 && type.starts_with("UJOINT_") && is_axis(type[7]) && is_axis(type[8]) && type[7] != type[8]) {
      joint.type = JointType::universal;
      joint.axis = axis(type[7]);
      joint.axis2 = axis(type[8]);
    } else {
      problems_.add(ErrorCode::unsupported, joint.line, in_quotes(type) + " is not a joint type.",
                    "Use SPHERICAL, or UJOINT_ followed by two different axes (UJOINT_XY).");
    }
  }

  formats::Problems problems_;
  LoopsYaml out_;
  std::vector<LoopType> types_;
  std::vector<std::string> joint_types_;
};

}  // namespace

Result<LoopsYaml> read_loops_yaml(const SideFile& file) {
  formats::Problems problems(file.name);
  if (file.text.size() > max_yaml) return fail(ErrorCode::range, file.name, "The loops file has more than 4 MB.", "Give a smaller file.");
  if (!formats::plain_text(file.text, "YAML", problems)) return fail(problems.take());
  try {
    return LoopsYamlReader(file.name).read(file.text);
  } catch (const YAML::Exception& e) {
    return fail(ErrorCode::syntax, file.name + ":" + std::to_string(std::max(0, e.mark.line) + 1),
                "The text is not valid YAML (" + e.msg + ").", "Check brackets, quotes and indentation.");
  }
}

Error apply_loops(const LoopsYaml& yaml, const SideFile& file, const std::function<std::optional<LoopEnd>(std::string_view)>& find_frame,
                  const std::function<std::optional<int>(std::string_view)>& find_joint, RobotDraft& draft) {
  formats::Problems problems(file.name);
  const auto unknown = [&](int line, const std::string& kind, const std::string& name) {
    problems.add(ErrorCode::unknown, line, "The description has no " + kind + " " + in_quotes(name) + ".",
                 "Use a name from the description.");
  };
  for (const LoopsYaml::JointChange& change : yaml.joints) {
    const std::optional<int> link = find_joint(change.joint);
    if (!link) {
      unknown(change.line, "joint", change.joint);
      continue;
    }
    Joint& joint = draft.link(*link).joint;
    joint.type = change.type;
    joint.axis = change.axis;
    joint.axis2 = change.axis2;
    for (int i = 1; i < joint.nv(); ++i) joint.dofs[static_cast<std::size_t>(i)] = joint.dofs[0];
  }
  for (const LoopsYaml::Closure& closure : yaml.closures) {
    const std::optional<LoopEnd> a = find_frame(closure.a), b = find_frame(closure.b);
    if (!a) unknown(closure.line, "link, joint or frame", closure.a);
    if (!b) unknown(closure.line, "link, joint or frame", closure.b);
    if (!a || !b) continue;
    draft.spec.loops.push_back({.name = closure.a + " = " + closure.b,
                                .type = closure.type,
                                .link_a = a->link < 0 ? "" : draft.link(a->link).name,
                                .link_b = b->link < 0 ? "" : draft.link(b->link).name,
                                .X_AJ = a->X,
                                .X_BJ = b->X});
    draft.loop_joints.push_back({draft.spec.loops.back().name, draft.spec.loops.back().name});
  }
  for (const LoopsYaml::Driven& driven : yaml.driven) {
    if (const std::optional<int> link = find_joint(driven.joint))
      draft.driven.push_back(draft.link(*link).name);
    else
      unknown(driven.line, "joint", driven.joint);
  }
  return problems.take();
}

}  // namespace ugoki::robot_formats
