#pragma once
// What a writer could not write, by kind; internal to robot_formats.

#include <map>
#include <string>
#include <vector>

#include "ugoki/mechanism/mechanism.h"
#include "ugoki/robot_formats/robot_draft.h"

namespace ugoki::robot_formats {

/// Names that share one sentence.
class WrittenNotes {
 public:
  /// @param sentence with "%" where the names go
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

/// A joint of one freedom about (along) an axis; what joints of several freedoms are made of.
struct SimpleJoint {
  bool slides = false;
  Vec3 axis;
  int freedom = 0;  ///< of the joint
};
/// Cylindrical, helical (two, of which the second follows the first), planar and universal joints, outermost first; revolute and prismatic
/// ones themselves; nothing for others.
[[nodiscard]] std::vector<SimpleJoint> simple_joints(const Joint& joint);

/// All loops, those of the virtual links included, as people write them.
[[nodiscard]] std::vector<LoopSpec> all_loops(const Mechanism& mechanism);

/// Limits from here on are none to the readers.
inline constexpr double no_limit = 1e10;

}  // namespace ugoki::robot_formats
