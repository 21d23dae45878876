#include "ugoki/formats/bvh_hierarchy.h"

#include <map>
#include <set>

#include "ugoki/base/number.h"

namespace ugoki::formats {
namespace {

/// A ROOT, JOINT or End Site whose closing brace has not been read yet.
struct OpenNode {
  int joint = -1;   ///< index in the skeleton; -1 while the node is an end site
  int parent = -1;  ///< index in the skeleton; -1: root
  bool end_site = false;
  bool has_offset = false, has_channels = false;
  Vec3 offset;  ///< in Ugoki's axes and file units
  std::string name;
  int line = 0;
};

class HierarchyReader {
 public:
  HierarchyReader(Scanner& scanner, const FileAxes& axes, Problems& problems) : scanner_(scanner), axes_(axes), problems_(problems) {}

  std::optional<BvhHierarchy> read() {
    skip_comments();
    if (!equal_ignoring_case(scanner_.word(), "HIERARCHY")) {
      problems_.add(ErrorCode::syntax, scanner_.line(), "The file does not begin with HIERARCHY.", "Check that it is a BVH file.");
      return std::nullopt;
    }
    while (step()) {
    }
    if (!problems_.empty()) return std::nullopt;
    make_names_unique();
    return std::move(out_);
  }

 private:
  /// Reads one statement. Returns false at MOTION, or after a problem that prevents further reading.
  bool step() {
    skip_comments();
    if (!scanner_.skip_space()) {
      const std::string inside = open_.empty() ? "before MOTION" : "inside " + in_quotes(open_.back().name);
      return stop(ErrorCode::truncated, scanner_.line(), "The file ends " + inside + ".", "The file was cut off; export or copy it again.");
    }
    if (scanner_.accept_on_line('}')) return close();
    // Some files have no line MOTION: the complete hierarchy is followed by 'Frames:'.
    if (open_.empty() && !out_.skeleton.joints.empty() && scanner_.peek().starts_with("Frames")) return finish();
    const std::string_view word = scanner_.word();
    if (equal_ignoring_case(word, "ROOT")) return open_joint(true);
    if (equal_ignoring_case(word, "JOINT")) return open_joint(false);
    if (equal_ignoring_case(word, "End")) return open_end_site();
    if (equal_ignoring_case(word, "OFFSET")) return read_offset();
    if (equal_ignoring_case(word, "CHANNELS")) return read_channels();
    if (equal_ignoring_case(word, "MOTION")) return finish();
    return stop(ErrorCode::syntax, scanner_.line(), in_quotes(word) + " is not a word of a BVH hierarchy.",
                "Use JOINT, End Site, OFFSET, CHANNELS, a brace or MOTION.");
  }

  void skip_comments() {
    while (scanner_.peek().starts_with('#')) scanner_.rest_of_line();
  }

  bool stop(ErrorCode code, int line, std::string message, std::string remedy) {
    problems_.add(code, line, std::move(message), std::move(remedy));
    return false;
  }

  bool expect_open_brace(const std::string& name) {
    skip_comments();
    scanner_.skip_space();
    if (scanner_.accept_on_line('{')) return true;
    return stop(ErrorCode::syntax, scanner_.line(), "The opening brace of " + in_quotes(name) + " is missing.",
                "Add { after the joint's name.");
  }

  bool open_joint(bool root) {
    const int line = scanner_.line();
    std::string name = utf8(scanner_.rest_of_line('{'));
    if (root != open_.empty())
      return stop(ErrorCode::structure, line, root ? "A ROOT is inside another joint." : "A JOINT is outside of any ROOT.",
                  "Check the braces above this line.");
    if (name.empty()) {
      name = "joint" + std::to_string(out_.skeleton.joints.size() + 1);
      out_.remarks.push_back("The joint on line " + std::to_string(line) + " has no name; it was named '" + name + "'.");
    }
    if (!open_.empty() && !make_parent(open_.back())) return false;
    OpenNode node;
    node.name = std::move(name);
    node.line = line;
    node.parent = open_.empty() ? -1 : open_.back().joint;
    if (!add_joint(node)) return false;
    return push(std::move(node));
  }

  bool open_end_site() {
    const int line = scanner_.line();
    std::string_view name = scanner_.rest_of_line('{');
    if (name.size() >= 4 && equal_ignoring_case(name.substr(0, 4), "Site")) name.remove_prefix(4);
    while (!name.empty() && (name.front() == ' ' || name.front() == '\t')) name.remove_prefix(1);
    if (open_.empty()) return stop(ErrorCode::structure, line, "An End Site is outside of any joint.", "Check the braces above this line.");
    if (!make_parent(open_.back())) return false;
    OpenNode node;
    node.end_site = true;
    node.name = name.empty() ? open_.back().name + "_end" : utf8(name);
    node.line = line;
    node.parent = open_.back().joint;
    return push(std::move(node));
  }

  bool push(OpenNode node) {
    if (open_.size() >= max_depth)
      return stop(ErrorCode::range, node.line, "Joints are nested more than " + std::to_string(max_depth) + " deep.",
                  "Check the braces of the file.");
    if (!expect_open_brace(node.name)) return false;
    open_.push_back(std::move(node));
    return true;
  }

  bool add_joint(OpenNode& node) {
    if (out_.skeleton.joints.size() >= max_joints)
      return stop(ErrorCode::range, node.line, "The file has more than " + std::to_string(max_joints) + " joints.",
                  "Check that it is a motion-capture skeleton.");
    SkeletonJoint joint;
    joint.name = node.name;
    joint.parent = node.parent;
    joint.offset = node.offset;
    joint.rotation_order.clear();
    node.joint = static_cast<int>(out_.skeleton.joints.size());
    out_.skeleton.joints.push_back(std::move(joint));
    return true;
  }

  /// Makes the node a joint if it is not one yet: an End Site with children or channels counts as a joint.
  bool make_parent(OpenNode& node) { return node.joint >= 0 || add_joint(node); }

  bool read_offset() {
    const int line = scanner_.line();
    if (open_.empty()) return stop(ErrorCode::structure, line, "An OFFSET is outside of any joint.", "Check the braces above this line.");
    Vec3 v;
    for (int i = 0; i < 3; ++i) {
      const std::string_view token = scanner_.word_on_line();
      const auto value = measured_number(token);
      if (!value) {
        NumberFault fault = number_fault(token);
        if (token.empty())
          fault = {ErrorCode::syntax, "Three numbers are needed, " + std::to_string(i) + " found.", "Add the missing numbers."};
        problems_.add(fault.code, line, "OFFSET of " + in_quotes(open_.back().name) + ": " + fault.message, fault.remedy);
        scanner_.rest_of_line();
        open_.back().has_offset = true;
        return !problems_.full();
      }
      v[i] = *value;
    }
    if (!scanner_.rest_of_line('}').empty())
      return stop(ErrorCode::syntax, line, "OFFSET has more than three numbers.", "Remove everything after the third number.");
    OpenNode& node = open_.back();
    if (node.has_offset) return stop(ErrorCode::duplicate, line, in_quotes(node.name) + " has two OFFSETs.", "Remove one of them.");
    node.has_offset = true;
    node.offset = axes_.from_file(v);
    if (node.joint >= 0) out_.skeleton.joints[static_cast<std::size_t>(node.joint)].offset = node.offset;
    return true;
  }

  bool read_channels() {
    const int line = scanner_.line();
    if (open_.empty()) return stop(ErrorCode::structure, line, "CHANNELS is outside of any joint.", "Check the braces above this line.");
    OpenNode& node = open_.back();
    if (node.has_channels) return stop(ErrorCode::duplicate, line, in_quotes(node.name) + " has CHANNELS twice.", "Remove one of them.");
    node.has_channels = true;
    const std::string_view token = scanner_.word_on_line();
    const auto count = parse_long(token);
    if (!count || *count < 0 || *count > 6)
      return stop(ErrorCode::range, line,
                  "The number of CHANNELS of " + in_quotes(node.name) + " is " + in_quotes(token) + "; it must be 0 to 6.",
                  "Write the number of channel names that follow it.");
    if (*count == 0) return true;
    if (!make_parent(node)) return false;
    SkeletonJoint& joint = out_.skeleton.joints[static_cast<std::size_t>(node.joint)];
    bool seen_position[3] = {false, false, false};
    for (long i = 0; i < *count; ++i) {
      const std::string_view name = scanner_.word();  // some programs break long lists into several lines
      const std::string_view kind = name.empty() ? name : name.substr(1);
      const std::size_t axis = name.empty() ? std::string_view::npos : std::string_view("XYZxyz").find(name[0]);
      const bool rotation = equal_ignoring_case(kind, "rotation");
      if (axis == std::string_view::npos || !(rotation || equal_ignoring_case(kind, "position")))
        return stop(ErrorCode::unknown, scanner_.line(),
                    "Channel " + std::to_string(i + 1) + " of " + std::to_string(*count) + " of " + in_quotes(node.name) + " is " +
                        in_quotes(name) + ", which is not a channel.",
                    "Use Xposition, Yposition, Zposition, Xrotation, Yrotation or Zrotation, and check the number after CHANNELS.");
      const int a = static_cast<int>(axis % 3);
      if (rotation) {
        if (joint.dofs.size() == 3)
          return stop(ErrorCode::structure, scanner_.line(), in_quotes(node.name) + " has more than three rotation channels.",
                      "Keep three of them.");
        MeasuredDof dof;
        dof.axis = axes_.unit(a);
        joint.dofs.push_back(dof);
        joint.rotation_order += "XYZ"[a];
      } else {
        if (seen_position[a])
          return stop(ErrorCode::duplicate, scanner_.line(), in_quotes(node.name) + " has the channel " + in_quotes(name) + " twice.",
                      "Remove one of them.");
        seen_position[a] = true;
        joint.translates = true;
      }
      out_.channels.push_back({node.joint, rotation, a});
    }
    if (const std::string_view rest = scanner_.rest_of_line('}'); !rest.empty() && rest.front() != '#')
      return stop(ErrorCode::syntax, scanner_.line(), in_quotes(node.name) + " has more channel names than the number after CHANNELS.",
                  "Correct the number after CHANNELS.");
    return true;
  }

  bool close() {
    if (open_.empty())
      return stop(ErrorCode::structure, scanner_.line(), "A closing brace has no opening brace.", "Remove it, or check the braces above.");
    const OpenNode node = std::move(open_.back());
    open_.pop_back();
    if (!node.has_offset) {
      problems_.add(ErrorCode::structure, node.line, in_quotes(node.name) + " has no OFFSET.", "Add its OFFSET with three numbers.");
      return !problems_.full();
    }
    if (node.joint < 0) out_.skeleton.joints[static_cast<std::size_t>(node.parent)].end_sites.push_back(node.offset);
    return true;
  }

  bool finish() {
    if (!open_.empty()) {
      const OpenNode& node = open_.back();
      return stop(ErrorCode::structure, scanner_.line(),
                  "MOTION precedes the closing brace of " + in_quotes(node.name) + " (line " + std::to_string(node.line) + ").",
                  "Add the missing brace.");
    }
    if (out_.skeleton.joints.empty())
      return stop(ErrorCode::structure, scanner_.line(), "The hierarchy has no ROOT.", "Export the file with its skeleton.");
    if (out_.channels.empty())
      return stop(ErrorCode::structure, scanner_.line(), "No joint has channels, so nothing can move.", "Export the file with channels.");
    return false;
  }

  void make_names_unique() {
    std::set<std::string, std::less<>> used;
    std::map<std::string, int, std::less<>> uses;
    for (const SkeletonJoint& j : out_.skeleton.joints) used.insert(j.name);
    for (SkeletonJoint& j : out_.skeleton.joints) {
      int& n = uses[j.name];
      if (++n == 1) continue;
      std::string name;
      do name = j.name + "_" + std::to_string(n++);
      while (!used.insert(name).second);
      --n;
      if (out_.remarks.size() < 20) out_.remarks.push_back("Two joints are named '" + j.name + "'; one was renamed to '" + name + "'.");
      j.name = std::move(name);
    }
  }

  Scanner& scanner_;
  const FileAxes& axes_;
  Problems& problems_;
  BvhHierarchy out_;
  std::vector<OpenNode> open_;
};

}  // namespace

std::optional<BvhHierarchy> read_bvh_hierarchy(Scanner& scanner, const FileAxes& axes, Problems& problems) {
  return HierarchyReader(scanner, axes, problems).read();
}

}  // namespace ugoki::formats
