#pragma once
// Repetition of a cyclic motion over several cycles ("rounds"), so that algorithms that use neighbouring frames need no special case at
// the seam.

#include "ugoki/motion/clip.h"

namespace ugoki::motion_edit {

/// Number of frames of one cycle of a cyclic motion. The last frame is not counted, because it is the first frame of the next cycle.
[[nodiscard]] inline int round_frames(const Motion& motion) { return motion.frames - 1; }

/// Returns 1 + 2 `around` consecutive cycles; the middle one is `motion` itself. Contact labels are repeated. The result is not marked as
/// cyclic. `motion` must have at least 2 frames.
[[nodiscard]] Motion several_rounds(const Motion& motion, const Mechanism& mechanism, int around);
/// Returns three consecutive cycles.
[[nodiscard]] inline Motion three_rounds(const Motion& motion, const Mechanism& mechanism) { return several_rounds(motion, mechanism, 1); }

/// Returns the middle one of the 1 + 2 `around` cycles `rounds`. The last frame of the result is its first frame displaced by `cycle` (the
/// displacement of one cycle).
[[nodiscard]] Motion middle_round(const Motion& rounds, const Mechanism& mechanism, const Placement& cycle, int around = 1);

}  // namespace ugoki::motion_edit
