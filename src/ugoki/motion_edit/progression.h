#pragma once
// The even way that a cyclic motion makes over the ground, against which the figure sways.

#include "ugoki/motion/clip.h"

namespace ugoki::motion_edit {

/// A frame on the floor that moves along an arc at constant speed and turns at a constant rate, with the figure's mean heading: after one
/// cycle it has made the cycle's displacement exactly. Seen from it, a cyclic motion is periodic.
struct Progression {
  Placement start;        ///< at phase 0
  double vx = 0, vy = 0;  ///< m in a cycle, forwards and to the left, in its own axes
  double turn = 0;        ///< rad in a cycle

  /// Where it is at a phase (cycles from the first frame; any number).
  [[nodiscard]] Placement at(double phase) const;
  /// Displacement of one cycle in the world.
  [[nodiscard]] Placement cycle() const { return at(1) * inverse(start); }
};

/// The progression of a cyclic motion. Nothing moves where the root is fixed.
[[nodiscard]] Progression find_progression(const Motion& motion, const Mechanism& mechanism);

}  // namespace ugoki::motion_edit
