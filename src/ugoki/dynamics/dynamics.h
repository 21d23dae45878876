#pragma once
// Dynamics of open link systems: tau = M(q) vdot + b(q, v) - sum_B J_B^T F_B   (Nagashima 1999, eq. (1)).
//
// Sources: Featherstone, Rigid Body Dynamics Algorithms (2008), ch. 5-7; Nagashima (1999), section 5.
// Symbols and units: q [nq] m | rad; v [nv] m/s | rad/s; vdot [nv] m/s^2 | rad/s^2; tau [nv] N | N m; gravity m/s^2, world axes;
// `external` [links] wrenches F_B (N m, N) on the links about the world origin in world axes, or empty. J_B is the Jacobian of link B.
// Nothing here allocates except where stated. Use one Workspace per thread.
// Joint armature is part of M. Springs, dampers and friction are not included (see joint_forces.h and contact/stepper.h).

#include "ugoki/dynamics/workspace.h"

namespace ugoki::dynamics {

// Functions that start from q and v. They neither use nor change the results of update_kinematics() in `ws`. They are the fastest
// functions. They compute in link frames, so their accuracy does not depend on a link's distance from the base.

/// Joint forces that produce `vdot` (recursive Newton-Euler; Featherstone ch. 5). O(links).
/// @param vdot [nv]; empty: zero, then tau = b @param tau [nv, out] must not alias an input
void calc_inverse_dynamics(const Mechanism& m, Workspace& ws, std::span<const double> q, std::span<const double> v,
                           std::span<const double> vdot, const Vec3& gravity, std::span<const Vec6> external, std::span<double> tau);

/// Accelerations (articulated-body algorithm; Featherstone ch. 7). O(links). @param vdot [nv, out] must not alias an input
/// @return false if an articulated inertia is singular; `vdot` is then not valid
[[nodiscard]] bool calc_forward_dynamics(const Mechanism& m, Workspace& ws, std::span<const double> q, std::span<const double> v,
                                         std::span<const double> tau, const Vec3& gravity, std::span<const Vec6> external,
                                         std::span<double> vdot);

/// Inertia matrix as chain rows (Workspace::chain: only entries of DOFs and their ancestors) in ws.M, by the composite-rigid-body algorithm
/// (Featherstone ch. 6). Allocates the rows in the first call if the constructor of `ws` did not (Workspace::make_rows). O(nv depth).
void calc_inertia_rows(const Mechanism& m, Workspace& ws, std::span<const double> q);

// Staged functions: they use the results of update_kinematics() in `ws`.

/// Computes poses, motion subspaces, velocities and inertias of all links into `k`, for the functions below. The poses have the same bits
/// as those of calc_poses().
void update_kinematics(const Mechanism& m, std::span<const double> q, std::span<const double> v, Kinematics& k);
/// Computes pose, motion subspace and velocity of one link, and of those links between it and the base that are not known yet. Inertias
/// are not computed. The values have the same bits as those of update_kinematics(). O(links of the path).
/// @param known [links] not 0: the link is computed already, at the same q and v; the function sets the entries of links that it computes
void update_path_kinematics(const Mechanism& m, std::span<const double> q, std::span<const double> v, int link, std::span<char> known,
                            Kinematics& k);

/// Joint forces that produce `vdot` (recursive Newton-Euler). O(links).
/// @param vdot [nv]; empty: zero, then tau = b @param tau [nv, out] must not alias `vdot`
void calc_inverse_dynamics(const Mechanism& m, Workspace& ws, std::span<const double> vdot, const Vec3& gravity,
                           std::span<const Vec6> external, std::span<double> tau);

/// Bias forces b(q, v) at the positions of update_kinematics() but at other velocities. Does not change the velocities in `ws`. O(links).
/// @param q [nq] the positions given to update_kinematics() @param v [nv] @param b [nv, out] must not alias `v`
void calc_bias_forces(const Mechanism& m, Workspace& ws, std::span<const double> q, std::span<const double> v, const Vec3& gravity,
                      std::span<const Vec6> external, std::span<double> b);

/// Inertia matrix as chain rows in ws.M (composite-rigid-body algorithm). Allocates like calc_inertia_rows() above. O(nv depth).
void calc_inertia_rows(const Mechanism& m, Workspace& ws);

/// Inertia matrix as a full matrix; also sets ws.M. @param M [nv * nv, out]
void calc_inertia_matrix(const Mechanism& m, Workspace& ws, std::span<double> M);
/// Copies ws.M to a full matrix. @param M [nv * nv, out]
void copy_inertia_rows(const Workspace& ws, std::span<double> M);

/// Factors ws.M + diag(extra) = L^T D L into ws.L and ws.D_inverse. The factor has no fill-in (Featherstone ch. 6.5).
/// @param extra [nv] added to the diagonal, or empty
/// @return velocity index of the first DOF whose pivot is not positive (it moves no inertia), or -1
[[nodiscard]] int factor(Workspace& ws, std::span<const double> extra);

/// Solves with the factor: x <- (L^T D L)^-1 x. @param x [nv, in and out]
void solve(const Workspace& ws, std::span<double> x);

/// Forward dynamics by the articulated-body algorithm. O(links).
/// @return false if an articulated inertia is singular; `vdot` is then not valid
[[nodiscard]] bool calc_forward_dynamics(const Mechanism& m, Workspace& ws, std::span<const double> tau, const Vec3& gravity,
                                         std::span<const Vec6> external, std::span<double> vdot);

/// Forward dynamics with the sparse factor of M: vdot = M^-1 (tau - b). O(nv depth^2). @return false if M is singular
[[nodiscard]] bool calc_forward_dynamics_by_factor(const Mechanism& m, Workspace& ws, std::span<const double> tau, const Vec3& gravity,
                                                   std::span<const Vec6> external, std::span<double> vdot);

/// Forward dynamics by the unit-vector method of Nagashima (1999): b = ID(0); column i of A is ID(e_i) - b; dense solve of eq. (2). This is
/// the reference that the other methods must agree with. O(nv^3). Allocates. @return false if A is singular
[[nodiscard]] bool calc_forward_dynamics_by_unit_vectors(const Mechanism& m, Workspace& ws, std::span<const double> tau,
                                                         const Vec3& gravity, std::span<const Vec6> external, std::span<double> vdot);

/// Jacobian of a point that is fixed in `link`: velocity = sum over k of rows[k] v[chain[k]], with chain = chain_of_link(ws, link).
/// @param p_W position of the point, m, world @param rows [chain length, out] velocity of the point per unit velocity of each DOF
void calc_point_jacobian(const Workspace& ws, int link, const Vec3& p_W, std::span<Vec3> rows);

/// Velocity [m/s] of the point of `link` that is at the world position p_W.
[[nodiscard]] Vec3 point_velocity(const Kinematics& k, int link, const Vec3& p_W);

/// Kinetic energy of the links [J], without armature.
[[nodiscard]] double kinetic_energy(const Mechanism& m, const Workspace& ws);
/// Potential energy [J] in uniform gravity, relative to the world origin.
[[nodiscard]] double potential_energy(const Mechanism& m, const Workspace& ws, const Vec3& gravity);
/// Momentum about the world origin: angular [N m s], linear [N s].
[[nodiscard]] Vec6 momentum(const Mechanism& m, const Workspace& ws);

/// Chain of a link: the DOFs that move it, from the base outwards. Empty for a link fixed to the world.
[[nodiscard]] inline std::span<const int> chain_of_link(const Workspace& ws, int link) {
  const int last = ws.link_chain[static_cast<std::size_t>(link)];
  if (last < 0) return {};
  const auto k = static_cast<std::size_t>(last);
  return std::span(ws.chain).subspan(static_cast<std::size_t>(ws.row_start[k]), static_cast<std::size_t>(ws.depth[k]) + 1);
}

/// Applies L^-T in place to a vector that is nonzero only on the chain of DOF `last`. Call factor() first.
/// @param y [depth[last] + 1, in and out] entries of the chain, root first
void apply_inverse_transposed_factor(const Workspace& ws, int last, std::span<double> y);

}  // namespace ugoki::dynamics
