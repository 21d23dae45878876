#pragma once
// Exact derivatives of inverse and forward dynamics on the tangent space.
//
//   tau = ID(q, v, vdot):  d tau / dq,  d tau / dv,  d tau / dvdot = M
//   vdot = FD(q, v, tau):  d vdot / dq = -M^-1 d tau / dq,  d vdot / dv = -M^-1 d tau / dv,  d vdot / dtau = M^-1
//
// d/dq_j is the derivative along q (+) e_j dt (joint_integrate): a turn about the link's own axis for spherical joints, then a shift along
// the joint frame's axis for floating ones. v, vdot, tau and the external wrenches (about the world origin) are held fixed.
//
// In world axes about one point the derivative of the force on link i along a freedom j that moves it is
//   df_i/dq_j = S_j x* (f_i + f_ext) + I_i Psi2_j + D_i Psi1_j,     df_i/dv_j = D_i S_j + I_i (Psi1_j + S_j')
//   Psi1_j = W x S_j,  Psi2_j = Y x S_j + W x Psi1_j,  D = V x* I - I V x + (I V) x~*
// with W, Y the velocity and acceleration of the joint's frame on which the axis S_j begins; I, D and f sum over subtrees.
// Source: Carpentier, Mansard, Analytical derivatives of rigid body dynamics algorithms (2018); Singh, Russell, Wensing, Efficient
// analytical derivatives of rigid-body dynamics using spatial vector algebra (2022), here for joints of any kind whose axes are
// constant in one of their two frames.

#include "ugoki/dynamics/workspace.h"

namespace ugoki::dynamics {

/// Results and scratch; caller-owned, sized once, one a thread.
///
/// Entries live where a freedom j is on the chain of freedom k (Workspace::chain): `below` holds d tau_k / d_j, `above` holds
/// d tau_j / d_k; all others are zero. expand() writes full matrices.
struct InverseDerivatives {
  /// Sizes the rows of `ws` too, where that was not done yet (Workspace::make_rows).
  InverseDerivatives(const Mechanism& mechanism, Workspace& ws);

  std::vector<double> below_q, above_q;  ///< [chain entries] N m/rad and the like
  std::vector<double> below_v, above_v;  ///< [chain entries] N m s/rad and the like

  // Scratch of the recursions
  std::vector<Vec6> S_dot, psi1, psi2;  ///< [nv]
  std::vector<Vec6> turn_q, turn_v;     ///< [nv] change of the force on the moved subtree
  std::vector<Vec6> A, f, f_ext;        ///< [links]
  std::vector<Inertia> I;               ///< [links] composite
  std::vector<Mat3> E;                  ///< [links] angular block of D, composite
  std::vector<Vec3> p;                  ///< [links] linear momentum, composite
};

/// d tau / dq and d tau / dv in `d`, d tau / dvdot = M as chain rows in ws.M (armature included). O(nv depth), no allocation.
/// Call after update_kinematics() with the same v.
/// @param vdot [nv] or empty: zero @param external [links] about the world origin, or empty
void calc_inverse_dynamics_derivatives(const Mechanism& m, Workspace& ws, std::span<const double> v, std::span<const double> vdot,
                                       const Vec3& gravity, std::span<const Vec6> external, InverseDerivatives& d);

/// Full matrix of `below` and `above`. @param out [nv * nv] out[i * nv + j] = d tau_i / d_j
void expand(const Workspace& ws, std::span<const double> below, std::span<const double> above, std::span<double> out);

/// M^-1 as a full matrix from the factor in ws.L (factor() of ws.M). O(nv^2 depth), a few additions of rows for each row.
/// @param M_inverse [nv * nv, out]
void calc_inverse_of_inertia(const Workspace& ws, std::span<double> M_inverse);

/// X <- (L^T D L)^-1 X for many right-hand sides at once. O(nv depth columns). @param X [nv * columns] row by row
void solve_columns(const Workspace& ws, std::span<double> X, std::size_t columns);

struct ForwardDerivatives {
  ForwardDerivatives(const Mechanism& mechanism, Workspace& ws);

  std::vector<double> vdot;  ///< [nv]
  std::vector<double> dq;    ///< [nv * nv] row by row: d vdot_i / dq_j
  std::vector<double> dv;    ///< [nv * nv]
  std::vector<double> dtau;  ///< [nv * nv] M^-1, symmetric
  InverseDerivatives inverse;
};

/// Forward dynamics and its derivatives. O(nv^2 depth), no allocation. Call after update_kinematics() with the same v.
/// @param tau [nv] @param external [links] about the world origin, or empty
/// @return the freedom at which the inertia is singular, or -1
[[nodiscard]] int calc_forward_dynamics_derivatives(const Mechanism& m, Workspace& ws, std::span<const double> v,
                                                    std::span<const double> tau, const Vec3& gravity, std::span<const Vec6> external,
                                                    ForwardDerivatives& d);

}  // namespace ugoki::dynamics
