#pragma once
// Recognises the human anatomy of a measured skeleton: the body part and side of each joint.

#include <array>
#include <string>
#include <vector>

#include "ugoki/motion/skeleton.h"

namespace ugoki::body {

/// The part of the body that starts at a joint.
enum class Part { other, pelvis, trunk, neck, head, hip, thigh, shank, foot, toes, shoulder, upper_arm, forearm, hand, fingers, thumb };

/// Body part and side of one joint.
struct SidedPart {
  Part part = Part::other;
  int side = 0;  ///< 1 left, -1 right, 0 middle
};

/// First joints of the sections of a leg (thigh, shank, foot, toes) or an arm (upper arm, forearm, hand, fingers); -1: missing.
struct Limb {
  int proximal = -1, distal = -1, end = -1, tip = -1;
};

/// Result of find_anatomy. Joint indices are those of the skeleton.
struct Anatomy {
  bool human = false;
  std::string why_not;                     ///< if `human` is false: a sentence with the reason
  Mat3 R_WA = Mat3::identity();            ///< world orientation of the anatomical frame A at rest: x forward, y left, z up
  std::vector<Vec3> p;                     ///< [joints] m, rest positions in the axes of A
  std::vector<std::vector<int>> children;  ///< [joints]
  std::vector<SidedPart> parts;            ///< [joints]; `other` everywhere if not human
  std::vector<int> trunk;                  ///< joints of the trunk from the pelvis upwards
  std::vector<int> neck;                   ///< neck joints upwards, the head last
  std::array<Limb, 2> legs, arms;          ///< left, right
  std::vector<int> mirror;                 ///< [joints] mirrored joint on the other side; -1: none (joints in the middle)
  std::vector<Vec3> bone;                  ///< [joints] m, vector from the joint to the far end of its bone, in the axes of A
  std::vector<char> helper;                ///< [joints] 1: the joint only follows and gets no mass of its own; empty: none

  /// Bone [m] of joint i averaged with the mirrored joint's bone. The results for both sides are bitwise equal except for the sign of y.
  [[nodiscard]] Vec3 symmetric_bone(int i) const;
};

/// Finds pelvis, trunk, neck, head, legs and arms from the shape of the joint tree at rest. Joint names decide which side is left and
/// identify collar bones, wrists and thumbs. Without such names, the mirror plane of the limbs and the direction of the toes decide.
[[nodiscard]] Anatomy find_anatomy(const Skeleton& skeleton);

/// Label of the joint's link (Link::label), for example "thigh left"; empty if the part is unknown.
[[nodiscard]] std::string label_of(const Anatomy& anatomy, int joint);

}  // namespace ugoki::body
