#pragma once
// Mapping of a skeleton to a body plan: which joints begin the sections of the limbs. It reports what was recognised and corrects it.

#include <string>
#include <utility>
#include <vector>

namespace ugoki::body {

/// A section of a limb and the joint at which it begins.
struct SectionJoint {
  std::string section;  ///< leg: "thigh", "shank", "foot", "toes"; arm: "upper arm", "forearm", "hand", "fingers"; or the limb's own name
  std::string joint;    ///< name of the joint; empty: the limb has no such section
};

/// A limb of a character.
struct LimbMapping {
  std::string name;                    ///< "left leg", "right leg", "left arm", "right arm", "head" or "tail"
  double confidence = 1;               ///< 0 ... 1 that limb and sections are right
  std::string evidence;                ///< sentence: how limb and sections were found
  std::vector<SectionJoint> sections;  ///< from the trunk outwards
  std::vector<int> joints;             ///< indices of all joints of the limb, for display; not part of a correction
};

/// Body plan and limbs of a character. A four-legged animal has its hind legs in the legs and its forelegs in the arms.
struct AnatomyMapping {
  std::string plan;                                         ///< "human", "four legs" or "other"; empty in a correction: as recognised
  double confidence = 0;                                    ///< 0 ... 1 that the plan is right
  std::vector<LimbMapping> limbs;                           ///< in a correction: the limbs to correct; missing limbs stay as recognised
  std::vector<std::pair<std::string, std::string>> labels;  ///< of markers: label in the file, label of a known marker set

  /// The limb with this name; null if there is none.
  [[nodiscard]] const LimbMapping* find(const std::string& name) const {
    for (const LimbMapping& l : limbs)
      if (l.name == name) return &l;
    return nullptr;
  }
};

}  // namespace ugoki::body
