#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>

#include "ugoki/base/number.h"
#include "ugoki/formats/asf.h"
#include "ugoki/formats/file_axes.h"

namespace ugoki::formats {
namespace {

/// A bone of the ASF file. The list of bones begins with the root; parents precede their children.
struct Bone {
  std::string name;
  int parent = -1;     ///< index in the list of bones
  int joint = -1;      ///< index in the skeleton; -1: a bone that only connects a joint to its child or end site
  Vec3 end;            ///< m, vector from the start to the end of the bone at rest, in Ugoki's axes (X forward, Y left, Z up)
  bool turns = false;  ///< the bone has the DOFs rx ry rz
  bool moves = false;  ///< the bone has the DOFs tx ty tz
};

class Writer {
 public:
  Writer(const MeasuredMotion& motion, const AmcWriteOptions& options)
      : motion_(motion), joints_(motion.skeleton.joints), decimals_(std::clamp(options.decimals, 1, 15)) {
    const double unit = options.metres_per_unit > 0 ? options.metres_per_unit : motion.skeleton.unit;
    unit_ = unit > 0 && std::isfinite(unit) ? unit : 1;
    children_.resize(joints_.size());
    for (std::size_t i = 0; i < joints_.size(); ++i)
      if (joints_[i].parent >= 0) children_[static_cast<std::size_t>(joints_[i].parent)].push_back(static_cast<int>(i));
  }

  AmcText write() {
    make_bones();
    write_skeleton();
    write_motion();
    return std::move(out_);
  }

 private:
  /// Returns a unique bone name: `wanted`, changed to a single word, and changed again if another bone has this name.
  std::string unique_name(const std::string& wanted) {
    std::string name;
    for (const char c : wanted)
      name += static_cast<unsigned char>(c) <= ' ' || c == '(' || c == ')' || c == ',' || c == '#' || c == ':' ? '_' : c;
    if (name.empty() || (name[0] >= '0' && name[0] <= '9') || name[0] == '-' || name[0] == '+') name.insert(0, "_");
    const std::string stem = name;
    for (int n = 2; name == "end" || name == "begin" || !names_.insert(name).second; ++n) name = stem + "_" + std::to_string(n);
    if (name != wanted) ++renamed_;
    return name;
  }

  bool ever_turns(std::size_t joint) const {
    for (std::size_t at = joint; at < motion_.rotations.size(); at += joints_.size())
      if (const Quat& q = motion_.rotations[at]; q.x != 0 || q.y != 0 || q.z != 0) return true;
    return false;
  }

  int add(Bone bone) {
    bones_.push_back(std::move(bone));
    return static_cast<int>(bones_.size()) - 1;
  }

  /// Adds the bone of a joint. Each child or end site that does not coincide with the end of this bone gets a connecting bone.
  void add_joint(int joint, int parent) {
    const SkeletonJoint& j = joints_[static_cast<std::size_t>(joint)];
    const std::vector<int>& children = children_[static_cast<std::size_t>(joint)];
    const bool root = bones_.empty();
    // A joint with exactly one child or end site: its bone ends there. Otherwise the bone has length zero.
    const bool one_end = !root && ((children.size() == 1 && j.end_sites.empty()) || (children.empty() && j.end_sites.size() == 1));
    Bone bone;
    bone.name = root ? "root" : unique_name(j.name);
    bone.parent = parent;
    bone.joint = joint;
    bone.turns = root || ever_turns(static_cast<std::size_t>(joint));
    bone.moves = root || j.parent < 0 || j.translates;
    if (one_end) bone.end = children.empty() ? j.end_sites[0] : joints_[static_cast<std::size_t>(children[0])].offset;
    if (root && j.name != "root") out_.notes.push_back("The root " + j.name + " was renamed to 'root', as the ASF format requires.");
    const int own = add(std::move(bone));
    for (const int c : children) {
      const SkeletonJoint& child = joints_[static_cast<std::size_t>(c)];
      int start = own;
      if (!one_end && norm(child.offset) > 0) {
        start = add({unique_name("to_" + child.name), own, -1, child.offset, false, false});
        ++connections_;
      }
      pending_.push_back({c, start});
    }
    if (one_end) return;
    for (const Vec3& e : j.end_sites) add({unique_name(j.name + "_end"), own, -1, e, false, false});
  }

  void make_bones() {
    names_.insert("root");
    std::vector<int> roots;
    for (std::size_t i = 0; i < joints_.size(); ++i)
      if (joints_[i].parent < 0) roots.push_back(static_cast<int>(i));
    if (roots.size() == 1) {
      add_joint(roots[0], -1);
    } else {
      add({"root", -1, -1, {}, true, true});
      for (const int r : roots) pending_.push_back({r, 0});
      out_.notes.push_back("The " + std::to_string(roots.size()) +
                           " roots were attached to an added root that does not move, because the ASF format has one root.");
    }
    while (!pending_.empty()) {
      const Pending next = pending_.back();
      pending_.pop_back();
      add_joint(next.joint, next.parent);
    }
    if (connections_ > 0)
      out_.notes.push_back(std::to_string(connections_) +
                           " bones without degrees of freedom were added: each leads to a joint that does not start at the end of its "
                           "parent's bone, and is named "
                           "'to_' and the name of the joint.");
    if (renamed_ > 0)
      out_.notes.push_back(std::to_string(renamed_) + " names were changed: names in the ASF format are single words, each unique.");
    bool limits = false;
    for (const SkeletonJoint& j : joints_)
      for (const MeasuredDof& f : j.dofs) limits = limits || f.limited;
    if (limits) out_.notes.push_back("Joint limits are not written: they refer to other axes than those of the file.");
  }

  void add_vector(std::string& out, const Vec3& v) {
    for (int i = 0; i < 3; ++i) out += ' ' + to_text(v[i]);
  }

  void write_skeleton() {
    std::string& out = out_.asf;
    out = ":version 1.10\n:name " + (motion_.name.empty() ? std::string("motion") : single_word(motion_.name)) +
          "\n:units\n  mass 1.0\n  length " + to_text(0.0254 / unit_) +
          "\n  angle deg\n:documentation\n  written by Ugoki\n:root\n  order TX TY TZ RX RY RZ\n  axis XYZ\n  position 0 0 0\n  "
          "orientation 0 0 0\n:bonedata\n";
    for (std::size_t i = 1; i < bones_.size(); ++i) {
      const Bone& b = bones_[i];
      const Vec3 end = axes_.to_file(b.end);
      const double length = norm(end);
      out += "  begin\n    id " + std::to_string(i) + "\n    name " + b.name + "\n    direction";
      add_vector(out, length > 0 ? end / length : Vec3{0, 0, 1});
      out += "\n    length " + to_text(length / unit_) + "\n    axis 0 0 0 XYZ\n";
      if (b.turns || b.moves) out += std::string("    dof") + (b.moves ? " tx ty tz" : "") + (b.turns ? " rx ry rz" : "") + "\n";
      if (i == 1 && motion_.skeleton.mass > 0) out += "    bodymass " + to_text(motion_.skeleton.mass) + "\n";
      out += "  end\n";
    }
    out += ":hierarchy\n  begin\n";
    std::vector<std::vector<std::size_t>> children(bones_.size());
    for (std::size_t i = 1; i < bones_.size(); ++i) children[static_cast<std::size_t>(bones_[i].parent)].push_back(i);
    for (std::size_t i = 0; i < bones_.size(); ++i) {
      if (children[i].empty()) continue;
      out += "    " + bones_[i].name;
      for (const std::size_t c : children[i]) out += ' ' + bones_[c].name;
      out += '\n';
    }
    out += "  end\n";
  }

  static std::string single_word(const std::string& name) {
    std::string word;
    for (const char c : name) word += static_cast<unsigned char>(c) <= ' ' ? '_' : c;
    return word;
  }

  void add_number(double value) {
    char buffer[400];
    if (!std::isfinite(value)) value = 0;
    auto [end, error] = std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed, decimals_);
    while (end[-1] == '0') --end;
    if (end[-1] == '.') --end;
    const std::string_view digits(buffer, static_cast<std::size_t>(end - buffer));
    out_.amc += ' ';
    out_.amc += digits == "-0" ? std::string_view("0") : digits;
  }

  void write_motion() {
    out_.amc = ":FULLY-SPECIFIED\n:DEGREES\n";
    out_.amc.reserve(static_cast<std::size_t>(motion_.frames) * bones_.size() * 50);
    for (int f = 0; f < motion_.frames; ++f) {
      out_.amc += std::to_string(f + 1) + '\n';
      for (const Bone& b : bones_) {
        if (!b.turns && !b.moves) continue;
        out_.amc += b.name;
        const std::size_t at = static_cast<std::size_t>(f) * joints_.size() + static_cast<std::size_t>(std::max(b.joint, 0));
        if (b.moves) {
          Vec3 p;
          if (b.joint >= 0) {
            p = motion_.translations[at];
            if (joints_[static_cast<std::size_t>(b.joint)].parent >= 0) p = p - joints_[static_cast<std::size_t>(b.joint)].offset;
          }
          p = axes_.to_file(p) / unit_;
          for (int i = 0; i < 3; ++i) add_number(p[i]);
        }
        if (b.turns) {
          // The file's axes x, y, z are Ugoki's axes y, z, x. R = Rz Ry Rx about the file's axes.
          Vec3 angles;
          if (b.joint >= 0) {
            const Mat3 R = to_matrix(motion_.rotations[at]);
            const Mat3 in_file = Mat3::columns(axes_.to_file(R * axes_.from_file({1, 0, 0})), axes_.to_file(R * axes_.from_file({0, 1, 0})),
                                               axes_.to_file(R * axes_.from_file({0, 0, 1})));
            const Vec3 zyx = to_euler(in_file, "ZYX");
            angles = {zyx.z, zyx.y, zyx.x};
          }
          for (int i = 0; i < 3; ++i) add_number(angles[i] * (180 / pi));
        }
        out_.amc += '\n';
      }
    }
  }

  struct Pending {
    int joint, parent;
  };

  const MeasuredMotion& motion_;
  const std::vector<SkeletonJoint>& joints_;
  FileAxes axes_;
  int decimals_;
  double unit_ = 1;
  std::vector<std::vector<int>> children_;
  std::vector<Bone> bones_;
  std::vector<Pending> pending_;
  std::set<std::string> names_;
  int renamed_ = 0, connections_ = 0;
  AmcText out_;
};

}  // namespace

AmcText write_amc(const MeasuredMotion& motion, const AmcWriteOptions& options) { return Writer(motion, options).write(); }

}  // namespace ugoki::formats
