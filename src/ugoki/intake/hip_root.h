#pragma once
// Place of the root joint of an animal.

#include <span>
#include <string>

#include "ugoki/body/recognise.h"
#include "ugoki/motion/skeleton.h"

namespace ugoki::intake {

/// Puts the root joint of a four-legged animal between its hips if it is far from them: on the floor, above the animal or in front of it.
/// The bones of the pelvis begin at the root, and would otherwise be poles that reach there. All other joints keep their world poses.
/// @param motions all on the skeleton of the character, whose pelvis is the root
/// @return sentence about it; empty if nothing was changed
[[nodiscard]] std::string move_root_to_hips(std::span<MeasuredMotion> motions, const body::Character& character);

}  // namespace ugoki::intake
