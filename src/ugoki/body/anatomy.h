#pragma once
// Which joint of a skeleton is which part of a human body.

#include <array>
#include <string>
#include <vector>

#include "ugoki/motion/skeleton.h"

namespace ugoki::body {

/// The part of the body that starts at a joint.
enum class Part { other, pelvis, trunk, neck, head, hip, thigh, shank, foot, toes, shoulder, upper_arm, forearm, hand, fingers, thumb };

struct Place {
  Part part = Part::other;
  int side = 0;  ///< 1 left, -1 right, 0 middle
};

/// Joints of a leg (thigh, shank, foot, toes) or an arm (upper arm, forearm, hand, fingers); -1 where there is none.
struct Limb {
  int proximal = -1, distal = -1, end = -1, tip = -1;
};

struct Anatomy {
  bool human = false;
  std::string why_not;           ///< a sentence, if no human
  Mat3 R_WA = Mat3::identity();  ///< anatomical frame at rest: x forward, y left, z up
  std::vector<Vec3> p;           ///< [joints] m, rest position in A's axes
  std::vector<std::vector<int>> children;
  std::vector<Place> places;       ///< [joints]
  std::vector<int> trunk;          ///< joints of the trunk from the pelvis up, pelvis first
  std::vector<int> neck;           ///< neck joints upwards and the head last
  std::array<Limb, 2> legs, arms;  ///< left, right
  std::vector<int> mirror;         ///< [joints] the same joint on the other side; -1 for those in the middle or without one
  std::vector<Vec3> bone;          ///< [joints] m, from the joint along its bone to the next joint or end, in A's axes

  /// Bone of joint i averaged with its mirrored partner: the same on both sides but for the sign of y.
  [[nodiscard]] Vec3 symmetric_bone(int i) const;
};

/// Finds pelvis, trunk, neck, head, legs and arms from the tree's shape at rest; names tell left from right,
/// collar bones, wrists and thumbs. Without names for left and right, mirrored limbs tell across, and toes forward.
[[nodiscard]] Anatomy find_anatomy(const Skeleton& skeleton);

/// Words for people and for matching: "thigh left".
[[nodiscard]] std::string label_of(const Anatomy& anatomy, int joint);

}  // namespace ugoki::body
