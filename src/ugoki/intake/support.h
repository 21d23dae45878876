#pragma once
// Finds parts of a motion in which something carries the character that the file does not contain.

#include <string>
#include <vector>

#include "ugoki/mechanism/mechanism.h"
#include "ugoki/motion/motion.h"

namespace ugoki::intake {

/// Sentence about frames in which nothing of the character is near the floor although it does not fall: it stands on stairs, sits on a
/// chair, hangs from a bar, or its height drifts. Without such frames of at least 0.25 s, a sentence about another reason for which
/// dynamics cannot follow the motion: the points near the floor do not balance the character, it accelerates downwards faster than gravity,
/// parts of it are below the floor, or its feet slide. Empty if there is none.
/// @param height m, of the character @param on_belt the character walks in place, so that its feet slide
[[nodiscard]] std::string describe_missing_support(const Mechanism& mechanism, const Motion& motion, double height, bool on_belt = false);

/// Heights by which a person or animal hovers: its lowest point is above the floor although it does not fall, as in hand-animated motions
/// whose root bobs more than the legs reach. Flights of the motion stay, and no fall is faster than gravity (lowering.h). Empty if the
/// animal does not hover, or if it hovers so high or so long that something else carries it (more than half of its height, or 1 s).
/// @param height m, of the character @return [frames] m
[[nodiscard]] std::vector<double> hovering_heights(const Mechanism& mechanism, const Motion& motion, double height);

}  // namespace ugoki::intake
