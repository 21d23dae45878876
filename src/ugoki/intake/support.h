#pragma once
// Finds parts of a motion in which something carries the character that the file does not contain.

#include <string>

#include "ugoki/mechanism/mechanism.h"
#include "ugoki/motion/motion.h"

namespace ugoki::intake {

/// Sentence about frames in which nothing of the character is near the floor although it does not fall: it stands on stairs, sits on a
/// chair, hangs from a bar, or its height drifts. Empty if there are none of at least 0.25 s.
/// @param height m, of the character
[[nodiscard]] std::string describe_missing_support(const Mechanism& mechanism, const Motion& motion, double height);

}  // namespace ugoki::intake
