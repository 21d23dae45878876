#pragma once
// Steps of an open link system under joint forces, without contact (contact/stepper.h steps with contact).

#include "ugoki/dynamics/dynamics.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::dynamics {

/// Semi-implicit Euler: v' = v + dt a(q, v), q' = q (+) v' dt. First order, bounded energy error on conservative systems.
/// Reads state.tau and state.external. @return false where the inertia is singular (the state is left as it was)
[[nodiscard]] bool step_semi_implicit(const Mechanism& m, Workspace& ws, State& state, const Vec3& gravity, double dt);

/// Classical Runge-Kutta of order 4 in the Lie algebra of the configuration manifold (Munthe-Kaas 1998), joint forces constant
/// over the step. @return false where the inertia is singular (the state is left as it was)
[[nodiscard]] bool step_rk4(const Mechanism& m, Workspace& ws, State& state, const Vec3& gravity, double dt);

}  // namespace ugoki::dynamics
