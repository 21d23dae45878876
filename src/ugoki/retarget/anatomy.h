#pragma once
// Anatomy of a mechanism (person, animal or robot): which of its links are trunk, neck, legs, arms and tail.

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/mechanism/mechanism.h"

namespace ugoki::retarget {

/// Section of a limb, from the trunk outwards. Leg: hip stub, thigh, shank, foot (hind leg: hock), toes (paw).
/// Arm: shoulder (scapula), upper arm, forearm, hand (carpus), fingers (fore paw).
enum class Slot { girdle, upper, lower, end, tip };
inline constexpr int slot_count = 5;
/// Name of the section and its key in a mapping file: "girdle", "upper" ...
[[nodiscard]] std::string_view name_of(Slot slot);

/// Index of a limb. On a four-legged character the hind legs are the legs and the fore legs are the arms.
enum class LimbName { left_leg, right_leg, left_arm, right_arm };
inline constexpr int limb_count = 4;
/// Name of the limb and its key in a mapping file: "left leg" ...
[[nodiscard]] std::string_view name_of(LimbName limb);

/// Links of one limb from the trunk to its tip, each the child of the previous one, divided into sections. A section can contain several
/// links (the three hinges of a robot's hip) or no link.
struct Limb {
  std::vector<int> links;
  std::array<int, slot_count + 1> begin{};  ///< section s consists of links[begin[s]] ... links[begin[s + 1] - 1]

  [[nodiscard]] bool found() const { return has(Slot::upper); }
  [[nodiscard]] bool has(Slot s) const { return begin[static_cast<std::size_t>(s)] < begin[static_cast<std::size_t>(s) + 1]; }
  /// First and last link of a section; -1 if the section is empty.
  [[nodiscard]] int first(Slot s) const;
  [[nodiscard]] int last(Slot s) const;
  /// Returns the section that contains the link. The link must be one of `links`.
  [[nodiscard]] Slot slot_of(int link) const;
};

/// Result of find_anatomy: link indices of one mechanism.
struct Anatomy {
  bool four_legs = false;
  int pelvis = -1;         ///< link that carries the legs (on a four-legged character the hind legs)
  std::vector<int> spine;  ///< links above the pelvis up to the chest, the chest last; empty if one link carries both arms and legs
  std::vector<int> neck;   ///< links above the chest, the head last
  std::array<Limb, limb_count> limbs;
  std::vector<int> tail;         ///< links from the base to the tip; empty: no tail
  Mat3 R_WA = Mat3::identity();  ///< world orientation of the anatomical axes (x forward, y left, z up) in the neutral position
  std::vector<Pose> X_WB;        ///< [links] poses in the neutral position, m
  double extent = 0;             ///< m, height from the lowest to the highest point in the neutral position

  [[nodiscard]] int chest() const { return spine.empty() ? pelvis : spine.back(); }
  [[nodiscard]] int head() const { return neck.empty() ? -1 : neck.back(); }
  [[nodiscard]] const Limb& limb(LimbName name) const { return limbs[static_cast<std::size_t>(name)]; }
};

/// Link names of one character, from a mapping file. If a member is empty, its links are found automatically.
struct AnatomyNames {
  std::string pelvis, chest, head;
  std::array<std::array<std::string, slot_count>, limb_count> limbs;  ///< first link of each section
  std::vector<std::string> tail;                                      ///< names of the first and last link, or of all links
  int four_legs = -1;                                                 ///< 1: four legs, 0: two legs, -1: found automatically
};

/// Finds the anatomy from labels (Link::label) if the links have them, otherwise from the shape of the link tree in the neutral position.
/// Link names decide which side is left. Errors: no pair of legs is found, or `names` contains an unknown link. A mapping file can correct
/// both errors.
[[nodiscard]] Result<Anatomy> find_anatomy(const Mechanism& mechanism, const AnatomyNames& names = {});

}  // namespace ugoki::retarget
