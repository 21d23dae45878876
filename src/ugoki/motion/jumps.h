#pragma once
// Measured joints that turn over from one frame to the next: markers that changed places, solvers that came to the other side of a
// singular position. No body moves like that.

#include <vector>

#include "ugoki/motion/motion.h"

namespace ugoki {

/// A joint's coordinates leap from frame - 1 to frame.
struct Jump {
  int link;
  int frame;
};

/// Turns of a joint by more than 70 degrees within a frame and faster than 80 rad/s (a pitcher's shoulder does not reach that where
/// motion is measured at 60 Hz or more). By link, then by frame.
[[nodiscard]] std::vector<Jump> find_jumps(const Motion& motion, const Mechanism& mechanism);

/// The motion without them: after a jump a joint goes on from where it was with the turns measured in its own axes. What turns over
/// about an axis of its parent and back comes back to its place, but for what it turned between the frames of the jumps.
[[nodiscard]] Motion without_jumps(const Motion& motion, const Mechanism& mechanism);

}  // namespace ugoki
