#pragma once
// Completes rigs of four-legged animals in which limbs, chest or head are not where a body needs them.

#include <span>
#include <string>
#include <vector>

#include "ugoki/motion/skeleton.h"

namespace ugoki::intake {

/// Finds four limbs by the ends that touch the ground in the motion, and gives them the tree of a four-legged animal:
///   - if the root carries the fore limbs, and something rises there but nothing reaches beyond the hind limbs, the joint of the hind limbs
///     becomes the root;
///   - the two limbs of a pair are attached to the closest joint that carries both (some rigs attach one of them a joint further on);
///   - if both pairs have the same joint, a joint for the chest is added between the fore limbs, which carries them and whatever is in
///     front of them;
///   - if nothing but limbs is attached to the chest, a neck and a head that do not turn are added in front of it.
/// A trunk or tail that reaches the floor has no side by name, and is no limb if four others have one. Limbs whose first joints are all at
/// one place begin at their second joints.
/// Names decide which limbs form a pair and which are in front, as far as they state it; otherwise symmetry and the head or tail decide.
/// World poses of the file's joints do not change.
/// @param motions all on the same skeleton
/// @return sentences about the changes; empty if no four limbs were found or nothing has to be changed (then nothing was changed)
[[nodiscard]] std::vector<std::string> complete_four_legs(std::span<MeasuredMotion> motions);

}  // namespace ugoki::intake
