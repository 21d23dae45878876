#pragma once
// Exact (analytical) derivatives of inverse dynamics ID and forward dynamics FD on the tangent space.
//
//   tau = ID(q, v, vdot):  d tau / dq,  d tau / dv,  d tau / dvdot = M
//   vdot = FD(q, v, tau):  d vdot / dq = -M^-1 d tau / dq,  d vdot / dv = -M^-1 d tau / dv,  d vdot / dtau = M^-1
//
// d/dq_j is the derivative along q (+) e_j dt (joint_integrate). For rotations of spherical and floating joints e_j is a rotation about an
// axis of the link; for translations of floating joints it is a shift along an axis of the joint frame. v, vdot, tau and the external
// wrenches (about the world origin) are constant.
//
// Link i has the spatial velocity V, acceleration A (gravity subtracted) and inertia I, in world axes about one point. This motion needs
// the force f_i = I A + V x* I V. If DOF j, with axis S_j, moves the link, the derivatives of f_i are
//   df_i/dq_j = S_j x* f_i + I_i Psi2_j + D_i Psi1_j,     df_i/dv_j = D_i S_j + I_i (Psi1_j + dS_j/dt)
//   Psi1_j = W x S_j,  Psi2_j = Y x S_j + W x Psi1_j,  D = V x* I - I V x + (I V) x~*
// x and x* are Featherstone's cross products with a motion and with a force, and h x~* m = m x* h. W and Y are the velocity and
// acceleration of the parent link plus those of the joint's DOFs with axes constant in the joint's frame J. I, D and f are summed over
// subtrees.
// Source: Carpentier, Mansard, Analytical derivatives of rigid body dynamics algorithms (2018); Singh, Russell, Wensing, Efficient
// analytical derivatives of rigid-body dynamics using spatial vector algebra (2022). Generalised here to all joints whose axes are
// constant in one of the joint's two frames (see axis_moves_with_link()).

#include "ugoki/dynamics/workspace.h"

namespace ugoki::dynamics {

/// Derivatives of inverse dynamics, and scratch memory. Owned by the caller; use one per thread.
///
/// Sparse: an entry exists for each pair of DOFs k and j where j is on the chain of k (Workspace::chain). With x = q or v, `below_x`
/// contains d tau_k / dx_j and `above_x` contains d tau_j / dx_k. All other derivatives are zero. expand() writes full matrices.
struct InverseDerivatives {
  /// Allocates. Also calls Workspace::make_rows() if `ws` has no rows yet.
  InverseDerivatives(const Mechanism& mechanism, Workspace& ws);

  std::vector<double> below_q, above_q;  ///< [chain entries] N m/rad, N/m, ...
  std::vector<double> below_v, above_v;  ///< [chain entries] N m s/rad, N s/m, ...

  // Scratch memory of the recursions over links; symbols: see the top of this file
  std::vector<Vec6> S_dot, psi1, psi2;  ///< [nv] dS/dt, Psi1 and Psi2 of each DOF
  std::vector<Vec6> df_dq, df_dv;       ///< [nv] derivative of the force on the subtree that the DOF moves
  std::vector<Vec6> A, f, f_ext;        ///< [links] acceleration, force f_i, external wrench
  std::vector<Inertia> I;               ///< [links] inertia of the link and all its descendants
  std::vector<Mat3> E;                  ///< [links] angular block of D, summed over the link and its descendants
  std::vector<Vec3> p;                  ///< [links] linear momentum, summed over the link and its descendants
};

/// Computes d tau / dq and d tau / dv into `d`, and d tau / dvdot = M as chain rows (Workspace::chain) into ws.M (armature included).
/// O(nv depth), no allocation. Call update_kinematics() with the same v first.
/// @param vdot [nv]; empty: zero @param external [links] wrenches about the world origin, or empty
void calc_inverse_dynamics_derivatives(const Mechanism& m, Workspace& ws, std::span<const double> v, std::span<const double> vdot,
                                       const Vec3& gravity, std::span<const Vec6> external, InverseDerivatives& d);

/// Writes `below` and `above` as a full matrix.
/// @param out [nv * nv, out] out[i * nv + j] = d tau_i / dx_j; x is q for below_q and above_q, v for below_v and above_v
void expand(const Workspace& ws, std::span<const double> below, std::span<const double> above, std::span<double> out);

/// M^-1 as a full matrix, from the factor in ws.L. Call factor() first. O(nv^2 depth).
/// @param M_inverse [nv * nv, out]
void calc_inverse_of_inertia(const Workspace& ws, std::span<double> M_inverse);

/// Solves for many right-hand sides: X <- (L^T D L)^-1 X. O(nv depth columns). @param X [nv * columns, in and out] row by row
void solve_columns(const Workspace& ws, std::span<double> X, std::size_t columns);

/// Derivatives of forward dynamics, and scratch memory. Owned by the caller; use one per thread.
struct ForwardDerivatives {
  ForwardDerivatives(const Mechanism& mechanism, Workspace& ws);

  std::vector<double> vdot;  ///< [nv] accelerations
  std::vector<double> dq;    ///< [nv * nv] row by row: d vdot_i / dq_j
  std::vector<double> dv;    ///< [nv * nv] d vdot_i / dv_j
  std::vector<double> dtau;  ///< [nv * nv] d vdot_i / dtau_j = M^-1, symmetric
  InverseDerivatives inverse;
};

/// Forward dynamics and its derivatives. O(nv^2 depth), no allocation. Call update_kinematics() with the same v first.
/// @param tau [nv] @param external [links] wrenches about the world origin, or empty
/// @return velocity index of the DOF at which the inertia matrix is singular, or -1
[[nodiscard]] int calc_forward_dynamics_derivatives(const Mechanism& m, Workspace& ws, std::span<const double> v,
                                                    std::span<const double> tau, const Vec3& gravity, std::span<const Vec6> external,
                                                    ForwardDerivatives& d);

}  // namespace ugoki::dynamics
