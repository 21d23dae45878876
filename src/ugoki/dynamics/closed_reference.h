#pragma once
// Dynamics of closed link systems the paper's way (section 5, 2-4): the reference that faster methods must agree with.
//
//   A_G vdot_G + b_G = H^T tau,   A_G = H^T A H,   b_G = H^T (A h + b),   vdot = H vdot_G + h            h = dH/dt v_G
//
// with A and b by unit accelerations through the open system's inverse dynamics (1), H from loop_partition.h. Exact and dense:
// O(rows nv rank + freedoms links). Symbols and units as in dynamics.h; nothing allocates.

#include "ugoki/dynamics/loop_closure.h"

namespace ugoki::dynamics {

// At what update_closed() left in `cw`:

/// vdot of all freedoms from those of theta_G. @param vdot_G [freedoms] @param vdot [nv, out]
void expand_acceleration(const ClosedWorkspace& cw, std::span<const double> vdot_G, std::span<double> vdot);

/// Forces of the driven joints that produce `vdot` (which the loops must allow): tau_G = W^T tau_open (3) = S^T tau_driven (4).
/// With more drives than freedoms the solution of least sum weight tau^2 is taken.
/// @param applied [nv] joint forces that act anyway (springs, dampers); empty: none
/// @param driven freedoms with a drive @param weights [driven] cost of each drive's force; empty: all 1
/// @param tau [nv, out] zero for what is not driven
/// @return false where the drives do not reach every freedom of the system
[[nodiscard]] bool calc_closed_inverse_dynamics(const Mechanism& m, ClosedWorkspace& cw, std::span<const double> vdot, const Vec3& gravity,
                                                std::span<const Vec6> external, std::span<const double> applied,
                                                std::span<const int> driven, std::span<const double> weights, std::span<double> tau);

/// Accelerations under joint forces, by unit accelerations of theta_G (2).
/// @return false where A_G is singular: a freedom that moves no mass
[[nodiscard]] bool calc_closed_forward_dynamics_by_unit_vectors(const Mechanism& m, ClosedWorkspace& cw, std::span<const double> tau,
                                                                const Vec3& gravity, std::span<const Vec6> external,
                                                                std::span<double> vdot);

/// Forces in the loops: A vdot + b = tau + J^T multipliers. Row k's multiplier is the force [N] or moment [N m] along its wrench
/// (loop_rows.h) on link b, its opposite on link a. Where rows are redundant the forces are not determined by rigid bodies: the
/// set of least norm is taken (moments measured against forces at cw.length). Open loops get zeros.
/// @param multipliers [rows, out]
void calc_loop_forces(const Mechanism& m, ClosedWorkspace& cw, std::span<const double> tau, const Vec3& gravity,
                      std::span<const Vec6> external, std::span<const double> vdot, std::span<double> multipliers);

// For integrators. Stages of a step have small gaps; both functions hold theta_G and let theta_S follow (coordinate
// partitioning), so that a Runge-Kutta method on q and v is one on theta_G alone, each stage on the closed manifold.

/// Closes positions and velocities of a state. @return what is left of the gap
[[nodiscard]] Closure project_closed_state(const Mechanism& m, std::span<double> q, std::span<double> v, ClosedWorkspace& cw);

/// Accelerations at the closed state nearest to (q, v). Near dead points and change points in motion, velocities and accelerations are
/// taken from the branch on which the system moves through, before and behind.
/// @return false where A_G is singular or the loops cannot be closed
[[nodiscard]] bool calc_closed_acceleration(const Mechanism& m, ClosedWorkspace& cw, std::span<const double> q, std::span<const double> v,
                                            std::span<const double> tau, const Vec3& gravity, std::span<const Vec6> external,
                                            std::span<double> vdot);

}  // namespace ugoki::dynamics
