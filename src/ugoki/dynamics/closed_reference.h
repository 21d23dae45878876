#pragma once
// Dynamics of closed link systems by the paper's method (section 5, 2-4): the reference that the faster methods must agree with.
//
//   A_G vdot_G + b_G = H^T tau,   A_G = H^T A H,   b_G = H^T (A h + b),   vdot = H vdot_G + h            h = dH/dt v_G
//
// A and b come from the open system's inverse dynamics with unit accelerations, paper eq. (1); H, eq. (5), from loop_partition.h.
// theta_G are the independent DOFs, theta_S the dependent ones. Exact and dense: O(rows nv rank + DOFs links). Symbols and units as in
// dynamics.h. Nothing allocates.

#include "ugoki/dynamics/loop_closure.h"

namespace ugoki::dynamics {

// The next four functions use the state that update_closed() left in `cw`.

/// Acceleration of all DOFs from that of theta_G: vdot = H vdot_G + h. @param vdot_G [cw.dofs()] @param vdot [nv, out]
void expand_acceleration(const ClosedWorkspace& cw, std::span<const double> vdot_G, std::span<double> vdot);

/// Forces of the driven joints that produce `vdot`: tau_G = W^T tau_open, paper eq. (3), and tau_G = S^T tau_driven, eq. (4).
/// `vdot` must be compatible with the loops. With more drives than DOFs, returns the solution with the minimum sum of weight * tau^2.
/// @param applied [nv] joint forces that act in addition to the drives (springs, dampers); empty: none
/// @param driven velocity indices of the DOFs with a drive @param weights [driven] cost of each drive's force; empty: all 1
/// @param tau [nv, out] N | N m; zero for DOFs without a drive
/// @return false if the drives cannot move every DOF of the closed system
[[nodiscard]] bool calc_closed_inverse_dynamics(const Mechanism& m, ClosedWorkspace& cw, std::span<const double> vdot, const Vec3& gravity,
                                                std::span<const Vec6> external, std::span<const double> applied,
                                                std::span<const int> driven, std::span<const double> weights, std::span<double> tau);

/// Accelerations under the joint forces `tau`, by unit accelerations of theta_G: paper eq. (2) with A_G and b_G.
/// @return false if A_G is singular: a DOF moves no mass
[[nodiscard]] bool calc_closed_forward_dynamics_by_unit_vectors(const Mechanism& m, ClosedWorkspace& cw, std::span<const double> tau,
                                                                const Vec3& gravity, std::span<const Vec6> external,
                                                                std::span<double> vdot);

/// Forces in the loops: A vdot + b = tau + J^T multipliers. The multiplier of row k is the force [N] or moment [N m] along the row's
/// wrench (loop_rows.h) on link b; the opposite acts on link a. If rows are redundant, rigid-body dynamics does not determine the forces.
/// The function then returns the solution of minimum norm, with moments divided by cw.length. Open loops get zeros.
/// @param multipliers [rows, out]
void calc_loop_forces(const Mechanism& m, ClosedWorkspace& cw, std::span<const double> tau, const Vec3& gravity,
                      std::span<const Vec6> external, std::span<const double> vdot, std::span<double> multipliers);

// For integrators. The stages of a step have small gaps. Both functions keep theta_G and solve for theta_S (coordinate partitioning), so
// a Runge-Kutta method on q and v is equivalent to one on theta_G alone, with each stage on the closed manifold.

/// Closes the positions and velocities of a state. @return the remaining gap, see Closure
[[nodiscard]] Closure project_closed_state(const Mechanism& m, std::span<double> q, std::span<double> v, ClosedWorkspace& cw);

/// Accelerations at the closed state with the same theta_G as (q, v). If a moving system is near a singular position (dead point or change
/// point), velocities and accelerations are interpolated from points before and after it on the same solution branch.
/// @return false if A_G is singular or the loops cannot be closed
[[nodiscard]] bool calc_closed_acceleration(const Mechanism& m, ClosedWorkspace& cw, std::span<const double> q, std::span<const double> v,
                                            std::span<const double> tau, const Vec3& gravity, std::span<const Vec6> external,
                                            std::span<double> vdot);

}  // namespace ugoki::dynamics
