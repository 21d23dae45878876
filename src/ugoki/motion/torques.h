#pragma once
// Torque-oriented motion data (Nagashima 1999, section 3.2): drive torques over time from a first state. Dynamics with these torques moves
// the mechanism from the first state on; coordinates of later times are results. Angle-oriented motion data (Motion::q) are the coordinates
// themselves. content/torque_conversion.h converts the two forms into each other.

#include <cstdint>
#include <vector>

#include "ugoki/motion/motion.h"

namespace ugoki {

/// Torques that are constant during each simulation step, and the state of which they begin. A motion that was computed as coordinates
/// (a gait) has this record without torques.
struct MotionTorques {
  double step = 0.002;         ///< s: duration of a row of `tau`, which is one simulation step
  std::vector<double> q0, v0;  ///< [nq], [nv] first state, in the world; the motion cannot be placed elsewhere
  std::vector<double> tau;     ///< [steps][nv] N m | N: forces on all DOFs; those of a floating root are external forces
  std::uint64_t path = 0;      ///< path_hash() of the motion to which the torques belong

  [[nodiscard]] std::size_t steps() const { return v0.empty() ? 0 : tau.size() / v0.size(); }
};

/// Hash of rate and coordinates of a motion.
[[nodiscard]] std::uint64_t path_hash(const Motion& motion);

/// Marks a motion as computed: its coordinates have no noise, and its contacts are those for which the coordinates were computed.
void mark_computed(Motion& motion);
/// True if mark_computed() was called, and neither coordinates nor rate were changed afterwards.
[[nodiscard]] bool is_computed(const Motion& motion);

/// Torques of the motion; null if it has none, or if its coordinates or its rate were changed after the torques were computed.
[[nodiscard]] const MotionTorques* torques_of(const Motion& motion);

/// Returns the problems that make the torques of a motion unusable with this mechanism: sizes that do not fit, a step outside 0.0001 ...
/// 0.1 s, values that are not finite. Empty if there are none, or if the motion has no torques.
[[nodiscard]] Error check_torques(const Motion& motion, const Mechanism& mechanism);

}  // namespace ugoki
