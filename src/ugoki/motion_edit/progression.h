#pragma once
// Mean movement of a cyclic motion over the ground, without the character's sway.

#include "ugoki/motion/clip.h"

namespace ugoki::motion_edit {

/// A coordinate frame on the floor that moves along an arc at constant speed and rotates at a constant rate, with the character's mean
/// heading. In one cycle it makes exactly the displacement of the cycle; relative to this frame, a cyclic motion is periodic.
struct Progression {
  Placement start;        ///< placement of the frame at phase 0
  double vx = 0, vy = 0;  ///< m per cycle, forwards and to the left, along the axes of the moving frame
  double turn = 0;        ///< rad per cycle

  /// Placement of the frame at a phase (in cycles since the motion's first frame; any finite value).
  [[nodiscard]] Placement at(double phase) const;
  /// Displacement of the frame in one cycle, in the world.
  [[nodiscard]] Placement cycle() const { return at(1) * inverse(start); }
};

/// Computes the progression of a cyclic motion. Its velocity is zero if the root does not move over the ground.
[[nodiscard]] Progression find_progression(const Motion& motion, const Mechanism& mechanism);

}  // namespace ugoki::motion_edit
