#pragma once
// Dynamics of closed link systems by the paper's method (Nagashima 1999, section 5, 2-4): the reference for the faster methods.
//
//   A_G vdot_G + b_G = H^T tau,   A_G = H^T A H,   b_G = H^T (A h + b),   vdot = H vdot_G + h            h = dH/dt v_G
//
// A and b (paper eq. (1)) come from the open system's inverse dynamics with unit accelerations. H (eq. (5)) comes from loop_partition.h.
// theta_G are the independent DOFs, theta_S the dependent ones. The method is exact, with dense matrices: O(rows nv rank + DOFs links).
// Other symbols and units are those of dynamics.h. Nothing allocates.

#include "ugoki/dynamics/loop_closure.h"

namespace ugoki::dynamics {

// The next four functions use the results of update_closed() in `cw`.

/// Accelerations of all DOFs from the accelerations vdot_G of theta_G: vdot = H vdot_G + h. @param vdot_G [cw.dofs()] @param vdot [nv, out]
void expand_acceleration(const ClosedWorkspace& cw, std::span<const double> vdot_G, std::span<double> vdot);

/// Forces of the driven joints that produce `vdot`: tau_G = W^T tau_open, paper eq. (3), and tau_G = S^T tau_driven, eq. (4).
/// H = dv/dv_G maps the velocities of the closed system to those of all joints. W is H; S consists of the rows of H of the driven DOFs.
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
/// wrench (loop_rows.h) on link b; its opposite acts on link a. If rows are redundant, rigid-body dynamics does not determine the forces.
/// The function then returns the solution of minimum norm, with moments divided by cw.length. Open loops get zeros.
/// @param multipliers [rows, out]
void calc_loop_forces(const Mechanism& m, ClosedWorkspace& cw, std::span<const double> tau, const Vec3& gravity,
                      std::span<const Vec6> external, std::span<const double> vdot, std::span<double> multipliers);

// Two functions for integrators, in whose stages the loops have small gaps. Both functions keep theta_G and solve for theta_S (coordinate
// partitioning). A Runge-Kutta method on q and v is then equivalent to one on theta_G alone, and the loops are closed in each stage.

/// Closes the positions and velocities of a state. @return the remaining gap, see Closure
[[nodiscard]] Closure project_closed_state(const Mechanism& m, std::span<double> q, std::span<double> v, ClosedWorkspace& cw);

/// Accelerations at the closed state with the same theta_G as (q, v). If a moving system is near a singular position (dead point or change
/// point), velocities and accelerations are interpolated from points before and after that position on the same solution branch.
/// @return false if A_G is singular or the loops cannot be closed
[[nodiscard]] bool calc_closed_acceleration(const Mechanism& m, ClosedWorkspace& cw, std::span<const double> q, std::span<const double> v,
                                            std::span<const double> tau, const Vec3& gravity, std::span<const Vec6> external,
                                            std::span<double> vdot);

}  // namespace ugoki::dynamics
