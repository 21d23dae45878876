#pragma once
// Ends of the paws, the head and the tail of an animal, as its mesh shows them.

#include <span>

#include "ugoki/body/recognise.h"
#include "ugoki/motion/skeleton.h"

namespace ugoki::intake {

/// Gives limbs, head and tail of an animal the end sites of the joints of the same name in another skeleton: limbs if left and right are
/// alike, and if the ends do not lift the other pair of paws from the level of the first (the mesh of a rump or of a whole leg can hang on
/// the last bone); the head if its end is in front of it (a muzzle, no antlers); head and tail if they carry no other joint.
/// @param motions all on the skeleton of the character  @param with_ends the file's skeleton with ends that were estimated from the mesh
/// @return true if any joint got ends
[[nodiscard]] bool restore_ends_of_meshes(std::span<MeasuredMotion> motions, const Skeleton& with_ends, const body::Character& character);

}  // namespace ugoki::intake
