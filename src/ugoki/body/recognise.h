#pragma once
// Recognises the character in a measured motion from the shape of its joint tree, its joints' names and its movement. The result does not
// depend on the rest pose of the file: files with the same world motion give the same result. docs/design/anatomy.md describes the method.

#include <span>
#include <string>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/body/anatomy.h"
#include "ugoki/body/mapping.h"
#include "ugoki/motion/skeleton.h"

namespace ugoki::body {

/// Kind of body plan.
enum class BodyPlan {
  human,      ///< two legs, two arms, a head
  four_legs,  ///< a trunk between hind legs and forelegs
  other       ///< anything else: birds, snakes, insects, machines, single limbs
};

/// Result of recognise_character. Joint indices are those of the skeleton.
struct Character {
  BodyPlan plan = BodyPlan::other;
  std::string why_not;                      ///< if the plan is `other`: a sentence with the reason
  double confidence = 0;                    ///< 0 ... 1: confidence in plan and limbs
  bool winged = false;                      ///< true: the limbs in `arms` are wings, and the body plan is `other`
  int pelvis = -1, chest = -1;              ///< joints that carry the (hind) legs and the arms (forelegs)
  int head = -1;                            ///< joint of the head
  std::vector<int> trunk;                   ///< joints from the pelvis to the chest, both included
  std::vector<int> neck;                    ///< joints above the chest, the head last
  std::vector<int> tail;                    ///< joints of the tail from its base
  std::array<Limb, 2> legs, arms;           ///< left, right
  std::vector<SidedPart> parts;             ///< [joints]
  std::vector<char> helper;                 ///< [joints] 1: the joint only follows (twist, end, hair, face) and gets no mass of its own
  std::vector<char> free;                   ///< [joints] 1: the joint moves far relative to its parent, so that no bone connects them
  std::vector<int> root_path;               ///< joints above the pelvis from the root; they only carry the character
  double leg_length = 0, trunk_length = 0;  ///< m, mean of thigh and shank; hips to shoulders; human and four-legged only
  std::array<double, 2> leg_confidence{}, arm_confidence{};  ///< 0 ... 1 that limb and sections are right; left, right
  double head_confidence = 0;                                ///< 0 ... 1
  bool corrected = false;                                    ///< a mapping was applied
  Vec3 up;                             ///< mean direction of trunk and legs in the file's world; human only; shorter than 1 if it varies
  std::vector<std::string> decisions;  ///< one sentence for each decision, with its evidence
};

/// Recognises the character of a motion. O(frames sampled * joints + joints^2); at most 240 frames are sampled.
/// @param correction sections of limbs that the caller specifies; null: none. Joints that the skeleton does not have are ignored (see
/// check_mapping). If the sections do not form a body, Character::why_not is the reason, and the plan is `other`.
[[nodiscard]] Character recognise_character(const MeasuredMotion& motion, const AnatomyMapping* correction = nullptr);

/// Plan, limbs, confidences and evidence of a character. Without recognised limbs the list of limbs is empty.
[[nodiscard]] AnatomyMapping mapping_of(const Character& character, const Skeleton& skeleton);

/// Errors of a correction: joints that the skeleton does not have, limbs and sections with unknown names. @param location of the problems
[[nodiscard]] Error check_mapping(const AnatomyMapping& mapping, const Skeleton& skeleton, const std::string& location);

/// Rotations [joints] that carry each joint from the file's rest pose to the canonical one: R_canonical = R_file * turn^T for the joint's
/// world orientation. For a human the canonical pose is a T pose (legs and trunk upright, arms stretched out sideways, feet as they stand);
/// for any other character the pose of the measured frame that is closest to its mean posture, heading along x. Empty if there are no
/// frames.
[[nodiscard]] std::vector<Mat3> canonical_turns(const MeasuredMotion& motion, const Character& character);

/// The same motion with another rest pose: joint i's frame is turned so that R_new = R_old * turns[i]^T. World positions do not change.
/// @param turns [joints] result of canonical_turns
[[nodiscard]] MeasuredMotion with_rest_pose(const MeasuredMotion& motion, std::span<const Mat3> turns);

/// The anatomy of a human character. @param skeleton the character's skeleton in its canonical rest pose
[[nodiscard]] Anatomy anatomy_of(const Character& character, const Skeleton& skeleton);

}  // namespace ugoki::body
