#pragma once
// Dynamics of open link systems: tau = M(q) vdot + b(q, v) - sum_B J_B^T F_B   (paper, eq. (1)).
//
// Sources: Featherstone, Rigid Body Dynamics Algorithms (2008), ch. 5-7; Nagashima (1999), section 5.
// Symbols and units: q [nq], v, vdot [nv], tau [nv] N | N m, gravity m/s^2, `external` [links] wrenches on the links about
// the world origin in world axes (may be empty). Nothing here allocates; one Workspace a thread.
// A freedom's armature counts as inertia; springs, dampers and friction are not included (see contact/stepper.h).

#include "ugoki/dynamics/workspace.h"

namespace ugoki::dynamics {

// From the state alone. These neither read nor write what update_kinematics() leaves in `ws`; they are the fastest, and in
// the frames of the links, so that they keep their digits however far a link is from the base.

/// Joint forces that produce `vdot` (recursive Newton-Euler); an empty `vdot` means zero: then tau = b. O(links).
/// @param tau [nv, out] must not alias an input
void calc_inverse_dynamics(const Mechanism& m, Workspace& ws, std::span<const double> q, std::span<const double> v,
                           std::span<const double> vdot, const Vec3& gravity, std::span<const Vec6> external, std::span<double> tau);

/// Accelerations (articulated bodies). O(links). @param vdot [nv, out] must not alias an input
/// @return false where an articulated inertia is singular
[[nodiscard]] bool calc_forward_dynamics(const Mechanism& m, Workspace& ws, std::span<const double> q, std::span<const double> v,
                                         std::span<const double> tau, const Vec3& gravity, std::span<const Vec6> external,
                                         std::span<double> vdot);

/// Inertia matrix as chain rows in ws.M (composite rigid bodies). O(nv depth).
void calc_inertia_rows(const Mechanism& m, Workspace& ws, std::span<const double> q);

// In stages, on the quantities that update_kinematics() leaves in `ws`.

/// Poses, motion subspaces, velocities and inertias of all links. The other functions work on what this left in `ws`.
void update_kinematics(const Mechanism& m, std::span<const double> q, std::span<const double> v, Workspace& ws);

/// Joint forces that produce `vdot` (recursive Newton-Euler). O(links). `tau` must not alias `vdot`.
/// An empty `vdot` means zero: then tau = b.
void calc_inverse_dynamics(const Mechanism& m, Workspace& ws, std::span<const double> vdot, const Vec3& gravity,
                           std::span<const Vec6> external, std::span<double> tau);

/// Inertia matrix as chain rows in ws.M (composite rigid bodies). O(nv depth).
void calc_inertia_rows(const Mechanism& m, Workspace& ws);

/// The same as a full matrix. @param M [nv * nv, out]
void calc_inertia_matrix(const Mechanism& m, Workspace& ws, std::span<double> M);
/// ws.M as a full matrix. @param M [nv * nv, out]
void copy_inertia_rows(const Workspace& ws, std::span<double> M);

/// Factors ws.M + diag(extra) = L^T D L without fill-in. @param extra [nv] or empty
/// @return the freedom whose pivot is not positive (a link that has no inertia there), or -1
[[nodiscard]] int factor(Workspace& ws, std::span<const double> extra);

/// x <- (L^T D L)^-1 x. @param x [nv]
void solve(const Workspace& ws, std::span<double> x);

/// Forward dynamics by the articulated-body method. O(links).
/// @return false where an articulated inertia is singular
[[nodiscard]] bool calc_forward_dynamics(const Mechanism& m, Workspace& ws, std::span<const double> tau, const Vec3& gravity,
                                         std::span<const Vec6> external, std::span<double> vdot);

/// Forward dynamics through the sparse factor of M. O(nv depth^2).
[[nodiscard]] bool calc_forward_dynamics_by_factor(const Mechanism& m, Workspace& ws, std::span<const double> tau, const Vec3& gravity,
                                                   std::span<const Vec6> external, std::span<double> vdot);

/// The paper's unit-vector method: b = ID(0); column i of A = ID(e_i) - b; dense solve (2). The reference that the others must
/// agree with. O(nv^3); the only function here that allocates.
[[nodiscard]] bool calc_forward_dynamics_by_unit_vectors(const Mechanism& m, Workspace& ws, std::span<const double> tau,
                                                         const Vec3& gravity, std::span<const Vec6> external, std::span<double> vdot);

/// J: 3 rows of a world point that is fixed in `link`, along each freedom of the link's chain: velocity = sum J[k] v[chain k].
/// @param rows [chain length, out], in the order of the link's chain
void calc_point_jacobian(const Workspace& ws, int link, const Vec3& p_W, std::span<Vec3> rows);

/// Velocity [m/s] of the world point p_W fixed in `link`.
[[nodiscard]] Vec3 point_velocity(const Workspace& ws, int link, const Vec3& p_W);

/// Kinetic energy [J]; potential energy [J] in a uniform gravity, zero at the world origin.
[[nodiscard]] double kinetic_energy(const Mechanism& m, const Workspace& ws);
[[nodiscard]] double potential_energy(const Mechanism& m, const Workspace& ws, const Vec3& gravity);
/// Momentum about the world origin: angular [N m s], linear [N s].
[[nodiscard]] Vec6 momentum(const Mechanism& m, const Workspace& ws);

/// Freedoms from the base to the deepest one that moves `link`; empty for a link fixed to the world.
[[nodiscard]] inline std::span<const int> chain_of_link(const Workspace& ws, int link) {
  const int last = ws.link_chain[static_cast<std::size_t>(link)];
  if (last < 0) return {};
  const auto k = static_cast<std::size_t>(last);
  return std::span(ws.chain).subspan(static_cast<std::size_t>(ws.row_start[k]), static_cast<std::size_t>(ws.depth[k]) + 1);
}

/// L^-T applied to a vector that lives on the chain of freedom `last`, in place. @param y [depth[last] + 1] root first
void apply_inverse_transposed_factor(const Workspace& ws, int last, std::span<double> y);

}  // namespace ugoki::dynamics
