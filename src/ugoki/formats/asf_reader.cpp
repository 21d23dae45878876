#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "ugoki/base/number.h"
#include "ugoki/formats/asf.h"
#include "ugoki/formats/file_axes.h"
#include "ugoki/formats/text.h"

namespace ugoki::formats {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Limits of one DOF, in the file's unit of angle or length.
struct Limit {
  double lower = -infinity, upper = infinity;
};

/// A bone, or the root, with the values that the file contains.
struct BoneText {
  std::string name;
  int line = 0;
  Vec3 direction;     ///< unit vector along the bone at rest, Ugoki's axes
  double length = 0;  ///< file's unit of length
  Vec3 axis_angles;   ///< file's unit of angle, in the order of axis_order
  std::string axis_order = "XYZ";
  std::vector<AsfDof> dofs;
  std::vector<Limit> limits;
  int limits_line = 0;  ///< line of the keyword 'limits'
  bool has_name = false, has_direction = false, has_length = false;
  int parent = -1;
  std::vector<int> children;
};

/// Splits a line into words, without the comment that begins with #. Parentheses and commas count as blanks.
std::vector<std::string_view> words_of(std::string_view line) {
  if (const std::size_t hash = line.find('#'); hash != std::string_view::npos) line = line.substr(0, hash);
  std::vector<std::string_view> words;
  constexpr std::string_view blanks = " \t\f\v(),";
  for (std::size_t at = 0; (at = line.find_first_not_of(blanks, at)) != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(blanks, at), line.size());
    words.push_back(line.substr(at, end - at));
    at = end;
  }
  return words;
}

bool is_infinite(std::string_view word) {
  if (word.starts_with('-') || word.starts_with('+')) word.remove_prefix(1);
  return equal_ignoring_case(word, "inf") || equal_ignoring_case(word, "infinity") || equal_ignoring_case(word, "1e999");
}

class AsfReader {
 public:
  AsfReader(std::string_view text, std::string_view file_name, const AsfOptions& options, Problems& problems)
      : scanner_(text), file_name_(file_name), options_(options), problems_(problems) {
    BoneText root;
    root.name = "root";
    root.has_name = root.has_direction = root.has_length = true;
    bones_.push_back(std::move(root));
    index_.emplace("root", 0);
  }

  std::optional<Asf> read(ReadNotes& notes) {
    bool readable = true;
    while (readable && !problems_.full() && scanner_.skip_space()) {
      line_ = scanner_.line();
      const std::string_view text = scanner_.rest_of_line();
      if (text.starts_with(':')) {
        readable = begin_section(text);
        continue;
      }
      const Words words = words_of(text);
      if (words.empty()) continue;
      switch (section_) {
        case Section::none:
          readable = stop(ErrorCode::syntax, line_, in_quotes(words[0]) + " precedes the first section.",
                          "Check that it is an ASF file; section names begin with a colon.");
          break;
        case Section::other: break;
        case Section::units: readable = read_unit(words); break;
        case Section::root: readable = read_root(words); break;
        case Section::bonedata: readable = read_bone(words); break;
        case Section::hierarchy: readable = read_hierarchy(words); break;
      }
    }
    line_ = scanner_.line();
    if (readable && inside_)
      stop(ErrorCode::truncated, line_,
           "The file ends before the 'end' of " +
               (section_ == Section::bonedata ? "bone " + in_quotes(bones_.back().name) : std::string(":hierarchy")) + ".",
           "The file was cut off; export or copy it again.");
    if (!problems_.empty()) return std::nullopt;
    for (const auto& [seen, name] : {std::pair{seen_root_, ":root"}, {seen_bones_, ":bonedata"}, {seen_hierarchy_, ":hierarchy"}})
      if (!seen) stop(ErrorCode::truncated, line_, std::string("Section ") + name + " is missing.", "Check that the ASF file is complete.");
    if (!problems_.empty() || !check_bones()) return std::nullopt;
    return build(notes);
  }

 private:
  enum class Section { none, other, units, root, bonedata, hierarchy };
  using Words = std::vector<std::string_view>;

  /// Adds a problem that prevents further reading; returns false.
  bool stop(ErrorCode code, int line, std::string message, std::string remedy) {
    problems_.add(code, line, std::move(message), std::move(remedy));
    return false;
  }
  /// Adds a problem after which reading can continue; returns false if the list of problems is full.
  bool complain(ErrorCode code, int line, std::string message, std::string remedy) {
    problems_.add(code, line, std::move(message), std::move(remedy));
    return !problems_.full();
  }

  bool begin_section(std::string_view text) {
    if (inside_)
      return stop(ErrorCode::structure, line_, "A section begins before the 'end' of the previous section.", "Add the missing 'end'.");
    const Words words = words_of(text);
    const std::string_view name = words[0];
    const auto is = [&](std::string_view s) { return equal_ignoring_case(name, s); };
    section_ = is(":units")       ? Section::units
               : is(":root")      ? Section::root
               : is(":bonedata")  ? Section::bonedata
               : is(":hierarchy") ? Section::hierarchy
                                  : Section::other;
    for (const auto& [section, seen, label] : {std::tuple{Section::root, &seen_root_, ":root"},
                                               {Section::bonedata, &seen_bones_, ":bonedata"},
                                               {Section::hierarchy, &seen_hierarchy_, ":hierarchy"}}) {
      if (section_ != section) continue;
      if (*seen) return stop(ErrorCode::duplicate, line_, std::string("Section ") + label + " occurs twice.", "Keep one of them.");
      *seen = true;
    }
    if (is(":name") && words.size() > 1) name_ = utf8(words[1]);
    return true;
  }

  /// Parses a finite number; adds a problem if `word` is not one. @param keyword the keyword of the line, for messages
  std::optional<double> number(std::string_view word, const char* keyword) {
    const auto value = measured_number(word);
    if (!value) {
      const NumberFault fault = number_fault(word);
      problems_.add(fault.code, line_, std::string("'") + keyword + "': " + fault.message, fault.remedy);
    }
    return value;
  }

  bool read_vector(const Words& words, const char* keyword, Vec3& v) {
    if (words.size() < 4)
      return complain(ErrorCode::syntax, line_, std::string("'") + keyword + "' needs three numbers.", "Add the missing numbers.");
    for (int i = 0; i < 3; ++i) {
      const auto value = number(words[static_cast<std::size_t>(i) + 1], keyword);
      if (!value) return !problems_.full();
      v[i] = *value;
    }
    return true;
  }

  bool read_order(std::string_view word, std::string& order) {
    std::string upper;
    for (const char c : word.substr(0, 4)) upper += c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
    std::string sorted = upper;
    std::sort(sorted.begin(), sorted.end());
    if (sorted != "XYZ")
      return complain(ErrorCode::syntax, line_, "The order of axes is " + in_quotes(word) + ".",
                      "Write each of the letters X, Y and Z once.");
    order = upper;
    return true;
  }

  bool read_unit(const Words& words) {
    const auto is = [&](std::string_view s) { return equal_ignoring_case(words[0], s); };
    if (words.size() < 2) return complain(ErrorCode::syntax, line_, in_quotes(words[0]) + " has no value.", "Write the unit after it.");
    if (is("mass") || is("length")) {
      const auto value = number(words[1], is("mass") ? "mass" : "length");
      if (!value) return !problems_.full();
      if (!(*value > 1e-9))
        return complain(ErrorCode::range, line_, "The scale " + in_quotes(words[1]) + " is not a positive number above 1e-9.",
                        "Write 1 if there is no scale.");
      (is("mass") ? mass_scale_ : length_scale_) = *value;
    } else if (is("angle")) {
      if (equal_ignoring_case(words[1], "deg") || equal_ignoring_case(words[1], "degrees"))
        degrees_ = true;
      else if (equal_ignoring_case(words[1], "rad") || equal_ignoring_case(words[1], "radians"))
        degrees_ = false;
      else
        return complain(ErrorCode::unknown, line_, "The unit of angles is " + in_quotes(words[1]) + ".", "Write deg or rad.");
    }
    return true;
  }

  bool read_dofs(const Words& words, std::size_t limit, std::vector<AsfDof>& dofs) {
    for (std::size_t i = 1; i < words.size(); ++i) {
      const std::string_view w = words[i];
      AsfDof dof;
      const std::size_t axis = w.size() == 2 ? std::string_view("xyzXYZ").find(w[1]) : std::string_view::npos;
      if (axis != std::string_view::npos && (w[0] == 'r' || w[0] == 'R')) {
        dof = {AsfDof::Kind::rotation, static_cast<int>(axis % 3)};
      } else if (axis != std::string_view::npos && (w[0] == 't' || w[0] == 'T')) {
        dof = {AsfDof::Kind::translation, static_cast<int>(axis % 3)};
      } else if (equal_ignoring_case(w, "l")) {
        dof = {AsfDof::Kind::length, 0};
      } else {
        return complain(ErrorCode::unknown, line_, in_quotes(w) + " is not a degree of freedom.", "Use rx, ry, rz, tx, ty, tz or l.");
      }
      const bool twice = std::any_of(dofs.begin(), dofs.end(), [&](const AsfDof& f) { return f.kind == dof.kind && f.axis == dof.axis; });
      if (twice)
        return complain(ErrorCode::duplicate, line_, "The degree of freedom " + in_quotes(w) + " occurs twice.", "Remove one of them.");
      if (dofs.size() >= limit)
        return complain(ErrorCode::range, line_, "There are more than " + std::to_string(limit) + " degrees of freedom.",
                        "Remove some of them.");
      dofs.push_back(dof);
    }
    return true;
  }

  bool read_root(const Words& words) {
    const auto is = [&](std::string_view s) { return equal_ignoring_case(words[0], s); };
    BoneText& root = bones_[0];
    root.line = line_;
    if (is("order")) {
      root.dofs.clear();
      return read_dofs(words, 6, root.dofs);
    }
    if (is("axis")) {
      if (words.size() < 2) return complain(ErrorCode::syntax, line_, "'axis' has no order.", "Write an order such as XYZ after it.");
      return read_order(words[1], root.axis_order);
    }
    if (is("position")) return read_vector(words, "position", root_position_);
    if (is("orientation")) return read_vector(words, "orientation", root.axis_angles);
    return complain(ErrorCode::unknown, line_, in_quotes(words[0]) + " is not a keyword of section :root.",
                    "Use order, axis, position or orientation.");
  }

  bool read_bone(const Words& words) {
    const auto is = [&](std::string_view s) { return equal_ignoring_case(words[0], s); };
    if (is("begin")) {
      if (inside_)
        return stop(ErrorCode::structure, line_, "A bone begins inside bone " + in_quotes(bones_.back().name) + ".",
                    "Add the 'end' of that bone.");
      if (bones_.size() > max_joints)
        return stop(ErrorCode::range, line_, "The file has more than " + std::to_string(max_joints) + " bones.",
                    "Check that it is a motion-capture skeleton.");
      inside_ = true;
      in_limits_ = false;
      bones_.emplace_back();
      bones_.back().line = line_;
      return true;
    }
    if (!inside_)
      return stop(ErrorCode::structure, line_, in_quotes(words[0]) + " is outside of any bone.", "Add the 'begin' of its bone.");
    BoneText& bone = bones_.back();
    if (in_limits_ && (is_infinite(words[0]) || measured_number(words[0]))) return read_limits(words, 0);
    in_limits_ = false;
    if (is("end")) {
      inside_ = false;
      return finish_bone(bone);
    }
    if (is("name")) {
      if (words.size() < 2) return complain(ErrorCode::syntax, line_, "'name' has no value.", "Write the name of the bone after it.");
      bone.name = std::string(words[1]);
      if (!index_.emplace(bone.name, static_cast<int>(bones_.size()) - 1).second)
        return complain(ErrorCode::duplicate, line_, "Two bones are named " + in_quotes(bone.name) + ".",
                        "Rename one of them, here and in the motion files.");
      bone.has_name = true;
      return true;
    }
    if (is("direction")) {
      Vec3 v;
      bone.has_direction = true;
      if (!read_vector(words, "direction", v)) return false;
      const double n = norm(v);
      bone.direction = axes_.from_file(std::fabs(n - 1) < 1e-3 ? v : normalized(v, {}));
      return true;
    }
    if (is("length")) {
      bone.has_length = true;
      const auto value = number(words.size() > 1 ? words[1] : std::string_view(), "length");
      if (value && *value < 0)
        return complain(ErrorCode::range, line_, "The length of bone " + in_quotes(bone.name) + " is negative.",
                        "Reverse the direction instead.");
      bone.length = value.value_or(0);
      return !problems_.full();
    }
    if (is("axis")) {
      if (!read_vector(words, "axis", bone.axis_angles)) return false;
      return words.size() < 5 || read_order(words[4], bone.axis_order);
    }
    if (is("dof")) {
      bone.dofs.clear();
      return read_dofs(words, 7, bone.dofs);
    }
    if (is("limits")) {
      bone.limits_line = line_;
      in_limits_ = true;
      half_limit_ = false;
      return read_limits(words, 1);
    }
    if (is("bodymass")) {
      const auto value = number(words.size() > 1 ? words[1] : std::string_view(), "bodymass");
      if (value && *value < 0)
        return complain(ErrorCode::range, line_, "The mass of bone " + in_quotes(bone.name) + " is negative.",
                        "Write a mass of 0 or more.");
      mass_ += value.value_or(0);
      return !problems_.full();
    }
    return true;  // id, cofmass and keywords of other programs are not used
  }

  bool read_limits(const Words& words, std::size_t from) {
    BoneText& bone = bones_.back();
    for (std::size_t i = from; i < words.size(); ++i) {
      double value = words[i].starts_with('-') ? -infinity : infinity;
      if (!is_infinite(words[i])) {
        const auto read = number(words[i], "limits");
        if (!read) return !problems_.full();
        value = *read;
      }
      if (!half_limit_) {
        if (bone.limits.size() > 7)
          return complain(ErrorCode::structure, line_,
                          "Bone " + in_quotes(bone.name) + " has more limits than the 7 degrees of freedom that a bone can have.",
                          "Write one pair for each degree of freedom.");
        bone.limits.push_back({value, infinity});
      } else {
        bone.limits.back().upper = value;
        if (!(bone.limits.back().lower <= value))
          return complain(ErrorCode::range, line_, "A lower limit of bone " + in_quotes(bone.name) + " is above its upper limit.",
                          "Swap the two numbers.");
      }
      half_limit_ = !half_limit_;
    }
    return true;
  }

  bool finish_bone(BoneText& bone) {
    if (!bone.has_name) return complain(ErrorCode::structure, bone.line, "The bone has no name.", "Add a line 'name ...'.");
    if (!bone.has_direction || !bone.has_length)
      return complain(ErrorCode::structure, bone.line,
                      "Bone " + in_quotes(bone.name) + " has no " + (bone.has_direction ? "length" : "direction") + ".", "Add it.");
    if (bone.length > 0 && norm(bone.direction) == 0)
      return complain(ErrorCode::range, bone.line, "The direction of bone " + in_quotes(bone.name) + " is zero.",
                      "Write a direction that is not zero.");
    if (!bone.limits.empty() && (bone.limits.size() != bone.dofs.size() || half_limit_))
      return complain(ErrorCode::structure, bone.limits_line,
                      "Bone " + in_quotes(bone.name) + " has " + std::to_string(bone.dofs.size()) +
                          " degrees of freedom, but its limits are " + std::to_string(bone.limits.size()) +
                          (half_limit_ ? " pairs, the last one incomplete." : " pairs."),
                      "Write one pair (lower upper) for each degree of freedom of 'dof'.");
    return true;
  }

  bool read_hierarchy(const Words& words) {
    if (words.size() == 1 && equal_ignoring_case(words[0], "begin")) {
      if (inside_) return stop(ErrorCode::structure, line_, "'begin' occurs twice.", "Remove it.");
      inside_ = true;
      return true;
    }
    if (words.size() == 1 && equal_ignoring_case(words[0], "end")) {
      if (!inside_) return stop(ErrorCode::structure, line_, "'end' has no 'begin'.", "Add 'begin' after :hierarchy.");
      inside_ = false;
      section_ = Section::other;
      return true;
    }
    if (!inside_) return stop(ErrorCode::structure, line_, "'begin' is missing after :hierarchy.", "Add it.");
    const auto parent = index_.find(words[0]);
    if (parent == index_.end())
      return complain(ErrorCode::unknown, line_, "There is no bone " + in_quotes(words[0]) + ".",
                      "Use the name of a bone in :bonedata, or root.");
    for (std::size_t i = 1; i < words.size(); ++i) {
      const auto child = index_.find(words[i]);
      if (child == index_.end() || child->second == 0) {
        if (!complain(ErrorCode::unknown, line_,
                      child == index_.end() ? "There is no bone " + in_quotes(words[i]) + "."
                                            : std::string("The root cannot be the child of a bone."),
                      "Use the name of a bone in :bonedata."))
          return false;
        continue;
      }
      BoneText& bone = bones_[static_cast<std::size_t>(child->second)];
      if (bone.parent >= 0) {
        if (!complain(ErrorCode::structure, line_,
                      "Bone " + in_quotes(words[i]) + " already has the parent " +
                          in_quotes(bones_[static_cast<std::size_t>(bone.parent)].name) + ".",
                      "Give it one parent only."))
          return false;
        continue;
      }
      bone.parent = parent->second;
      bones_[static_cast<std::size_t>(parent->second)].children.push_back(child->second);
    }
    return true;
  }

  /// Puts the bones into depth-first order (order_), each parent before its children. Returns false if a bone is not connected to the root.
  bool check_bones() {
    order_.push_back(0);
    std::vector<int> stack(bones_[0].children.rbegin(), bones_[0].children.rend());
    std::vector<char> reached(bones_.size(), 0);
    reached[0] = 1;
    while (!stack.empty()) {
      const int i = stack.back();
      stack.pop_back();
      reached[static_cast<std::size_t>(i)] = 1;
      order_.push_back(i);
      const auto& children = bones_[static_cast<std::size_t>(i)].children;
      stack.insert(stack.end(), children.rbegin(), children.rend());
    }
    for (std::size_t i = 0; i < bones_.size() && !problems_.full(); ++i) {
      const BoneText& b = bones_[i];
      if (reached[i]) continue;
      if (b.parent < 0)
        problems_.add(ErrorCode::structure, b.line, "Bone " + in_quotes(b.name) + " has no parent.", "Add it to :hierarchy.");
      else
        problems_.add(ErrorCode::structure, b.line, "Bone " + in_quotes(b.name) + " is not connected to the root.",
                      "Check :hierarchy for a cycle of bones.");
    }
    if (bones_[0].dofs.empty())
      problems_.add(ErrorCode::structure, bones_[0].line, "The root has no 'order'.",
                    "Add a line such as 'order TX TY TZ RX RY RZ' to :root.");
    return problems_.empty();
  }

  /// Returns the rotation from the bone's own frame to Ugoki's axes: rotations by axis_angles, applied in the order axis_order.
  /// @param angle_unit rad per file unit of angle
  Quat axis_of(const BoneText& bone, double angle_unit) const {
    Quat q;
    for (int i = 0; i < 3; ++i)
      q = axis_angle(axes_.unit(bone.axis_order[static_cast<std::size_t>(i)] - 'X'), bone.axis_angles[i] * angle_unit) * q;
    return normalized(q);
  }

  Asf build(ReadNotes& notes) {
    const bool unit_given = options_.metres_per_unit > 0 && std::isfinite(options_.metres_per_unit);
    const double unit = unit_given ? options_.metres_per_unit : 0.0254 / length_scale_;
    const double angle_unit = degrees_ ? pi / 180 : 1;
    Asf asf;
    asf.degrees = degrees_;
    asf.skeleton.unit = unit;
    asf.skeleton.mass = mass_ / mass_scale_;
    asf.skeleton.name = name_.empty() ? stem_of(file_name_) : name_;
    std::vector<int> joint_of_bone(bones_.size(), -1);
    for (const int index : order_) {
      const BoneText& from = bones_[static_cast<std::size_t>(index)];
      joint_of_bone[static_cast<std::size_t>(index)] = static_cast<int>(asf.bones.size());
      SkeletonJoint joint;
      joint.name = utf8(from.name);
      joint.rotation_order = "ZYX";
      if (from.parent >= 0) {
        const BoneText& parent = bones_[static_cast<std::size_t>(from.parent)];
        joint.parent = joint_of_bone[static_cast<std::size_t>(from.parent)];
        joint.offset = parent.direction * (parent.length * unit);
        for (const AsfDof& f : parent.dofs) joint.translates = joint.translates || f.kind == AsfDof::Kind::length;
      } else {
        joint.offset = axes_.from_file(root_position_) * unit;
      }
      if (from.children.empty() && index != 0) joint.end_sites.push_back(from.direction * (from.length * unit));
      const Quat axis = axis_of(from, angle_unit);
      for (std::size_t k = from.dofs.size(); k-- > 0;) {  // the last rotation in the file is the outermost
        const AsfDof& f = from.dofs[k];
        joint.translates = joint.translates || f.kind == AsfDof::Kind::translation;
        if (f.kind != AsfDof::Kind::rotation) continue;
        MeasuredDof dof;
        dof.axis = rotate(axis, axes_.unit(f.axis));
        if (!from.limits.empty() && (std::isfinite(from.limits[k].lower) || std::isfinite(from.limits[k].upper))) {
          dof.limited = true;
          dof.lower = from.limits[k].lower * angle_unit;
          dof.upper = from.limits[k].upper * angle_unit;
        }
        joint.dofs.push_back(dof);
      }
      asf.skeleton.joints.push_back(std::move(joint));
      asf.bones.push_back({from.name, axis, from.direction, from.dofs});
    }
    notes.metres_per_unit = unit;
    const double extent = rest_extent(asf.skeleton);
    std::string remark = unit_given ? ""
                                    : "Lengths are in inches divided by " + to_text(length_scale_) +
                                          ": the largest extent of the skeleton at rest is " + to_fixed(extent, 3) + " m.";
    if (!unit_given && !(extent > 0.3 && extent < 4)) remark += " This is outside of 0.3 to 4 m; set the unit of length if it is wrong.";
    if (!remark.empty()) notes.remarks.push_back(std::move(remark));
    return asf;
  }

  Scanner scanner_;
  std::string_view file_name_;
  const AsfOptions& options_;
  Problems& problems_;
  FileAxes axes_;
  Section section_ = Section::none;
  int line_ = 1;
  bool inside_ = false;      ///< true between the lines 'begin' and 'end'
  bool in_limits_ = false;   ///< true if the next line may continue the list 'limits'
  bool half_limit_ = false;  ///< true if the last pair in 'limits' has only its lower value so far
  bool seen_root_ = false, seen_bones_ = false, seen_hierarchy_ = false;
  bool degrees_ = true;
  double mass_scale_ = 1, length_scale_ = 1, mass_ = 0;
  std::string name_;
  Vec3 root_position_;                             ///< file axes and units
  std::vector<BoneText> bones_;                    ///< the first one is the root
  std::map<std::string, int, std::less<>> index_;  ///< index in bones_ by name
  std::vector<int> order_;                         ///< indices in bones_, depth first
};

}  // namespace

Result<Asf> read_asf(std::string_view text, std::string_view file_name, const AsfOptions& options, ReadNotes* notes) {
  Problems problems(file_name);
  const auto plain = plain_text(text, "ASF", problems);
  if (!plain) return fail(problems.take());
  ReadNotes collected;
  auto asf = AsfReader(*plain, file_name, options, problems).read(collected);
  if (!asf) return fail(problems.take());
  if (notes) *notes = std::move(collected);
  return std::move(*asf);
}

}  // namespace ugoki::formats
