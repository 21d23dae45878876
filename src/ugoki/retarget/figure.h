#pragma once
// Which links of a mechanism are trunk, neck, legs, arms and tail, whatever it is: a person, an animal, a robot.

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/mechanism/mechanism.h"

namespace ugoki::retarget {

/// Sections of a limb, from the trunk outwards. Leg: hip stub, thigh, shank, foot (hind leg: hock), toes (paw).
/// Arm: shoulder (scapula), upper arm, forearm, hand (carpus), fingers (fore paw).
enum class Slot { girdle, upper, lower, end, tip };
inline constexpr int slot_count = 5;
[[nodiscard]] std::string_view name_of(Slot slot);

/// Limbs in this order; on four legs the hind legs are the legs, the fore legs the arms.
enum class LimbName { left_leg, right_leg, left_arm, right_arm };
inline constexpr int limb_count = 4;
/// "left leg" ...
[[nodiscard]] std::string_view name_of(LimbName limb);

/// Links of one limb from the trunk to its tip, each the child of the one before, divided into sections. A section can hold several
/// links (a robot's three hinges of a hip) or none.
struct Limb {
  std::vector<int> links;
  std::array<int, slot_count + 1> begin{};  ///< section s: links[begin[s]] ... links[begin[s + 1] - 1]

  [[nodiscard]] bool found() const { return has(Slot::upper); }
  [[nodiscard]] bool has(Slot s) const { return begin[static_cast<std::size_t>(s)] < begin[static_cast<std::size_t>(s) + 1]; }
  /// First and last link of a section; -1 if it is empty.
  [[nodiscard]] int first(Slot s) const;
  [[nodiscard]] int last(Slot s) const;
  /// The section that the link belongs to. The link must be one of `links`.
  [[nodiscard]] Slot slot_of(int link) const;
};

struct Figure {
  bool four_legs = false;
  int pelvis = -1;         ///< link on which the (hind) legs hang
  std::vector<int> spine;  ///< links from the pelvis to the chest, the chest last; empty where arms and legs hang on one link
  std::vector<int> neck;   ///< links above the chest, the head last
  std::array<Limb, limb_count> limbs;
  std::vector<int> tail;         ///< from its base
  Mat3 R_WA = Mat3::identity();  ///< anatomical axes in the neutral position: x forward, y left, z up
  std::vector<Pose> X_WB;        ///< [links] poses in the neutral position
  double extent = 0;             ///< m, from the lowest to the highest place in the neutral position

  [[nodiscard]] int chest() const { return spine.empty() ? pelvis : spine.back(); }
  [[nodiscard]] int head() const { return neck.empty() ? -1 : neck.back(); }
  [[nodiscard]] const Limb& limb(LimbName name) const { return limbs[static_cast<std::size_t>(name)]; }
};

/// What a mapping file says about one figure; names of links. Empty: found by itself.
struct FigureNames {
  std::string pelvis, chest, head;
  std::array<std::array<std::string, slot_count>, limb_count> limbs;  ///< first link of each section
  std::vector<std::string> tail;                                      ///< first and last link, or all of them
  int four_legs = -1;                                                 ///< 1 yes, 0 no, -1 found
};

/// Finds the figure from labels (Link::label) where it has them, and otherwise from the shape of the tree in the neutral position; names
/// tell left from right. Errors: no pair of legs can be found, or `names` names what is not there; the remedy is a mapping file.
[[nodiscard]] Result<Figure> find_figure(const Mechanism& mechanism, const FigureNames& names = {});

}  // namespace ugoki::retarget
