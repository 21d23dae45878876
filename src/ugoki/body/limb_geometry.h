#pragma once
// Branches of a joint tree, their sections, and geometry of limbs from the motion. Internal to body.

#include <span>
#include <utility>
#include <vector>

#include "ugoki/body/anatomy.h"
#include "ugoki/body/motion_shape.h"

namespace ugoki::body {

/// A branch of the tree: the subtree below a child of a joint, with its longest path.
struct Branch {
  int from = -1;          ///< joint that carries the branch
  int first = -1;         ///< first joint of the branch
  int leaf = -1;          ///< end of its longest path
  double length = 0;      ///< m, from `from` along that path to the tip of the leaf
  std::vector<int> path;  ///< joints from `first` to `leaf`
};

/// Two similar branches of one joint.
struct Pair {
  int from = -1;
  int first = -1, second = -1;  ///< indices of branches
  double score = 0;
};

/// Sections of a limb as indices into its path; -1: none.
struct Sections {
  int upper = -1, lower = -1, end = -1, tip = -1;
  double cost = 1e9;
  double confidence = 0;  ///< 0 ... 1 that this division is right
};

/// True if the part belongs to a leg (is_leg), to an arm (is_arm), to the middle of the body (is_middle).
[[nodiscard]] inline bool is_leg(Part p) {
  return p == Part::hip || p == Part::thigh || p == Part::shank || p == Part::foot || p == Part::toes;
}
[[nodiscard]] inline bool is_arm(Part p) {
  return p == Part::shoulder || p == Part::upper_arm || p == Part::forearm || p == Part::hand || p == Part::fingers || p == Part::thumb;
}
[[nodiscard]] inline bool is_middle(Part p) { return p == Part::pelvis || p == Part::trunk || p == Part::neck || p == Part::head; }

/// Exchanges left and right.
inline void swap_sides(Branch (&legs)[2], Branch (&arms)[2], Sections (&leg_parts)[2], Sections (&arm_parts)[2]) {
  std::swap(legs[0], legs[1]);
  std::swap(arms[0], arms[1]);
  std::swap(leg_parts[0], leg_parts[1]);
  std::swap(arm_parts[0], arm_parts[1]);
}

/// Returns a positive value if the shape of two legs shows that the first leg is the left one. Left is up x forward; forward is the
/// direction of feet and knees. @param size m, of the character
[[nodiscard]] double facing_of(const MotionShape& motion, const Branch (&legs)[2], const Sections (&leg_parts)[2], double size);

/// Index of the finger that points away from the others: the thumb. @param tips last joint of each finger, at least two
[[nodiscard]] std::size_t find_thumb_among(const MotionShape& motion, const Limb& arm, std::span<const int> tips);

}  // namespace ugoki::body
