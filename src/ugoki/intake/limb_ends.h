#pragma once
// Joints that rigs with few bones lack: the ends of limbs, and the joint that carries the fore limbs.

#include <span>
#include <string>
#include <vector>

#include "ugoki/motion/skeleton.h"

namespace ugoki::intake {

/// Adds joints at the ends of limbs with one or two bones, so that they can be divided into upper part, lower part and foot (or hand). The
/// end of the last bone is its end site or, without one, as far beyond the joint as the joint is from its parent. A limb with one bone is
/// divided in its middle. A leaf whose name marks the end of its parent's bone ("Leg_end") counts as an end site. The new joints do not
/// turn. Necks, heads, tails and helper joints get none. World poses do not change.
/// @param motions all on the same skeleton
/// @return names of the joints whose limbs were extended
std::vector<std::string> add_limb_ends(std::span<MeasuredMotion> motions);

/// If all four limbs of an animal have one common joint, adds a joint that does not turn relative to it, and gives it the fore limbs, neck
/// and head. Names of limbs specify which are in front; without names, the limbs nearer to the head. World poses do not change.
/// @param motions all on the same skeleton
/// @return names of the limbs with a new parent
std::vector<std::string> add_chest(std::span<MeasuredMotion> motions);

}  // namespace ugoki::intake
