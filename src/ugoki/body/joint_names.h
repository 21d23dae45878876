#pragma once
// Body part and side that a joint's name states, for all usual naming conventions.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "ugoki/body/anatomy.h"

namespace ugoki::body {

/// Evidence from one joint's name.
struct NameEvidence {
  Part part = Part::other;    ///< the part that begins at the joint; `other`: the name states no part. "FrontLeg" is part of an arm
  Part second = Part::other;  ///< a second meaning of an ambiguous word ("leg": shank or thigh); `other`: none
  int side = 0;               ///< 1 left, -1 right, 0 not stated
  bool helper = false;        ///< a bone that only follows: twist, roll, end, effector, hair, cloth, face, camera ...
  bool control = false;       ///< a helper only by a word for controls of inverse kinematics ("IK", "ctrl", "target")
  bool weak = false;          ///< the word often names a joint next to the one where `part` begins ("wrist": in the forearm, or the hand)
  bool end = false;           ///< a helper that marks the end of its parent's bone ("HeadNub", "LeftToe_End")
  bool tail = false;          ///< a tail
  bool wing = false;          ///< a wing
  bool paw = false;           ///< a paw, hoof, claw or fin
  bool fore = false, hind = false;  ///< limb of a four-legged animal: in front, behind
};

/// Reads the joint names of one skeleton. Words that most joints share ("mixamorig", "Bip01", "CC_Base", "J_Bip", "def") are ignored.
/// Separators (_ - . : | blank), capitals and digits divide a name into words. English, German, French, Spanish, Italian and Latin names of
/// parts and sides are known.
[[nodiscard]] std::vector<NameEvidence> read_joint_names(std::span<const std::string> names);

}  // namespace ugoki::body
