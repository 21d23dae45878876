#pragma once
// Helpers of the writers: notes about what a format cannot store, and joints split into simple joints. Internal to robot_formats.

#include <map>
#include <string>
#include <vector>

#include "ugoki/mechanism/mechanism.h"
#include "ugoki/robot_formats/robot_draft.h"

namespace ugoki::robot_formats {

/// Collects notes. Notes with the same sentence become one note, which lists all names.
class WrittenNotes {
 public:
  /// @param sentence text in which "%" is replaced by the names
  void add(const std::string& sentence, const std::string& name) {
    std::vector<std::string>& names = names_[sentence];
    if (names.empty() || names.back() != name) names.push_back(name);
  }
  [[nodiscard]] std::vector<std::string> take() const {
    std::vector<std::string> out;
    for (const auto& [sentence, names] : names_) {
      std::string text = sentence;
      if (const std::size_t at = text.find('%'); at != std::string::npos) text.replace(at, 1, listed(names));
      out.push_back(std::move(text));
    }
    return out;
  }

 private:
  std::map<std::string, std::vector<std::string>> names_;
};

/// A joint of one DOF that rotates about an axis or slides along it. Joints of several DOFs are written as chains of simple joints.
struct SimpleJoint {
  bool slides = false;
  Vec3 axis;    ///< unit, in the joint frame
  int dof = 0;  ///< index of the DOF in the original joint
};
/// Returns the simple joints of a revolute, prismatic, cylindrical, planar, universal or helical joint, outermost first; empty for other
/// types. A helical joint gives two, both for DOF 0: first the rotation, then the translation.
[[nodiscard]] std::vector<SimpleJoint> simple_joints(const Joint& joint);

/// Returns all loops of the mechanism; each virtual link (LinkSpec::real) becomes a weld loop with its real link.
[[nodiscard]] std::vector<LoopSpec> all_loops(const Mechanism& mechanism);

/// A position limit (m, rad) of at least this magnitude is written as this value, which the readers treat as "no limit".
inline constexpr double no_limit = 1e10;

}  // namespace ugoki::robot_formats
