#pragma once
// Finds and removes jumps of measured joints: large rotations from one animation frame to the next, caused by swapped markers or by a
// solver that crossed a singular position.

#include <vector>

#include "ugoki/motion/motion.h"

namespace ugoki {

/// A jump of a link's joint between the animation frames `frame` - 1 and `frame`.
struct Jump {
  int link;
  int frame;
};

/// Finds rotations of a joint by more than 70 degrees within one frame and faster than 80 rad/s. In motion measured at 60 Hz or more,
/// not even a pitcher's shoulder moves that far in one frame. The result is sorted by link, then by frame.
[[nodiscard]] std::vector<Jump> find_jumps(const Motion& motion, const Mechanism& mechanism);

/// Returns the motion without jumps: the step of each jump is replaced by zero, and the later measured steps of the joint, in its own axes,
/// are integrated from there. A joint that jumps and later jumps back returns to its measured angles, except for the true rotation during
/// the frames of the two jumps.
[[nodiscard]] Motion without_jumps(const Motion& motion, const Mechanism& mechanism);

}  // namespace ugoki
