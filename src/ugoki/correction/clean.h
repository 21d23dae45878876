#pragma once
// Removes popping frames and jitter. Internal to correction.

#include "ugoki/motion/motion.h"

namespace ugoki::correction {

/// Replaces popping frames by interpolation: up to three frames in which a joint leaves its course and to which it returns at once.
/// @return number of replaced frames, summed over the joints
int remove_pops(const Mechanism& m, Motion& motion);

/// Filters all joints with SmoothMotion. @param cutoff Hz; 0: no filter
void remove_jitter(const Mechanism& m, Motion& motion, double cutoff);

/// Moves rotational joints that are beyond a limit to the limit.
void keep_limits(const Mechanism& m, Motion& motion);

}  // namespace ugoki::correction
