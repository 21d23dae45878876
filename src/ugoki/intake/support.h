#pragma once
// Finds parts of a motion in which something carries the character that the file does not contain.

#include <string>
#include <vector>

#include "ugoki/mechanism/mechanism.h"
#include "ugoki/motion/motion.h"

namespace ugoki::intake {

/// Sentence about frames in which nothing of the character is near the floor although it does not fall: it stands on stairs, sits on a
/// chair, hangs from a bar, or its height drifts. Empty if there are none of at least 0.25 s.
/// @param height m, of the character
[[nodiscard]] std::string describe_missing_support(const Mechanism& mechanism, const Motion& motion, double height);

/// Heights by which a person or animal hovers: its lowest point is above the floor although it does not fall, as in hand-animated motions
/// whose root bobs more than the legs reach. The heights are interpolated through flight phases and smoothed over 0.1 s. Empty if the
/// animal does not hover, or if it hovers so high or so long that something else carries it (more than half of its height, or 1 s).
/// @param height m, of the character @return [frames] m
[[nodiscard]] std::vector<double> hovering_heights(const Mechanism& mechanism, const Motion& motion, double height);

}  // namespace ugoki::intake
