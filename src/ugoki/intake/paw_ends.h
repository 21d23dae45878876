#pragma once
// Ends of the paws of an animal, as its mesh shows them.

#include <span>

#include "ugoki/body/recognise.h"
#include "ugoki/motion/skeleton.h"

namespace ugoki::intake {

/// Gives the limbs of an animal the end sites of the joints of the same name in another skeleton, if left and right are alike, and if they
/// do not lift the other pair of paws from the level of the first: the mesh of a rump or of a whole leg can hang on the last bone.
/// @param motions all on the skeleton of the character  @param with_ends the file's skeleton with ends that were estimated from the mesh
/// @return true if any joint got ends; false: nothing is useful, and the motions must not be used
[[nodiscard]] bool restore_paws(std::span<MeasuredMotion> motions, const Skeleton& with_ends, const body::Character& character);

}  // namespace ugoki::intake
