#pragma once
// Joins the parts of a character that hang on different branches although they move together.

#include <span>
#include <string>
#include <vector>

#include "ugoki/motion/skeleton.h"

namespace ugoki::intake {

/// Attaches a joint that moves relative to its parent, or has none, to the nearest joint of another branch to which it is rigid, with all
/// that it carries. (In some rigs of games pelvis and chest are both children of a root on the floor, or have no parent.) Of two branches
/// that are rigid to each other, the one with fewer joints is attached. World poses do not change.
/// @param motions all on the same skeleton
/// @return names of the joints with a new parent
std::vector<std::string> join_rigid_branches(std::span<MeasuredMotion> motions);

}  // namespace ugoki::intake
