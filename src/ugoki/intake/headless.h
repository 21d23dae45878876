#pragma once
// The head of persons whose rig has none.

#include <span>
#include <string>

#include "ugoki/motion/skeleton.h"

namespace ugoki::intake {

/// Adds a neck and a head that do not turn above the arms of a person whose joints name arms and legs on both sides, but neither neck nor
/// head: the mesh of the head follows the trunk. World poses of the other joints do not change.
/// @param motions all on the same skeleton
/// @return name of the joint that carries the head; empty if nothing was added
std::string add_head(std::span<MeasuredMotion> motions);

}  // namespace ugoki::intake
