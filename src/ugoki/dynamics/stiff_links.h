#pragma once
// Velocity changes of an open or closed link system under impulses, with stiffness added to links and DOFs, at a cost linear in the
// number of links:
//
//   (M + diag(extra) + sum_i J_i^T K_i J_i) x = r + J^T lambda - sum_i J_i^T f_i,   J (v + x) + c = 0
//
// J_i: Jacobian of link i [6 x nv], K_i: its stiffness, f_i: a wrench; J, lambda: rows and multipliers of the closed loops, c: wanted
// closing velocities. A contact of a link with the ground that acts like a damper adds stiffness to its own link only. Newton's method for
// contacts therefore costs as much as forward dynamics (contact/tree_contacts.h). The factor and its solutions are those of closed_links.h.
//
// The inverse inertia of link i, Omega_i = J_i (...)^-1 J_i^T with closed loops [6 x 6], is calculated for all links in one recursion from
// the base to the tips. It inverts only the blocks of the factor's own structure (selected inversion), with the relations of the recursion:
//   A' = A + S qdd,  qdd = -d (U . A + s . lambda) + e,  var e = d          joint with inverse pivot d, U and s of the factor
//   lambda_e = C^-T (Z^T A - Y lambda_o) + e,  var e = -(C C^T)^-1          loop eliminated at the link, o: loops coupled with it
// Sources: Featherstone (2008), ch. 7, 8; Takahashi, Fagan, Chin (1973), Formation of a sparse bus impedance matrix; Kreutz-Delgado, Jain,
// Rodriguez (1992), Recursive formulation of operational space control (Omega_i of open trees).

#include <span>
#include <vector>

#include "ugoki/dynamics/closed_links.h"

namespace ugoki::dynamics {

/// a += b c^T; the sum of all products that are added must be symmetric.
inline void add_product(ArticulatedInertia& a, const Vec6& b, const Vec6& c) {
  a.I.xx += b.w.x * c.w.x;
  a.I.yy += b.w.y * c.w.y;
  a.I.zz += b.w.z * c.w.z;
  a.I.xy += b.w.x * c.w.y;
  a.I.xz += b.w.x * c.w.z;
  a.I.yz += b.w.y * c.w.z;
  a.H += Mat3::outer(b.w, c.v);
  a.M.xx += b.v.x * c.v.x;
  a.M.yy += b.v.y * c.v.y;
  a.M.zz += b.v.z * c.v.z;
  a.M.xy += b.v.x * c.v.y;
  a.M.xz += b.v.x * c.v.z;
  a.M.yz += b.v.y * c.v.z;
}
/// Product of a symmetric 6 x 6 matrix and a spatial vector.
inline Vec6 product(const ArticulatedInertia& a, const Vec6& m) { return {a.I * m.w + a.H * m.v, transpose_times(a.H, m.w) + a.M * m.v}; }

/// Inverse inertias: velocity per unit impulse, about p0 in world axes.
struct LinkResponses {
  std::vector<ArticulatedInertia> link;  ///< [links] Omega_i, angular part first
  std::vector<double> dof;               ///< [nv] 1/kg | 1/(kg m^2)
  std::vector<Vec6> cross;               ///< [rows of loops at the links] covariance of the link's velocity and a multiplier
  std::vector<double> lambda;            ///< [blocks * 36] covariance of multipliers, blocks as Lambda in closed_links.h
  std::vector<double> Y;                 ///< [neighbours * 36] scratch of one elimination
};

/// Solver of the equation at the top for one mechanism, with its scratch memory. Use one per thread. Functions allocate nothing.
class StiffLinks {
 public:
  /// Uses the mechanism's own loops; those with Loop::closed set are closed.
  explicit StiffLinks(const Mechanism& m);
  /// Uses the given loops. @param closed [loops] 1 if the loop is closed
  StiffLinks(const Mechanism& m, std::vector<Loop> loops, std::span<const char> closed);

  /// Computes the rows of the closed loops. Call update_kinematics(q, v) and share_virtual_inertias() first.
  void update_rows(const Mechanism& m, const Workspace& ws, std::span<const double> q, std::span<const double> v);
  /// Rows of the loops at the last update_rows().
  [[nodiscard]] const LoopRows& rows() const { return links_.rows(); }
  [[nodiscard]] const ClosedLinks& links() const { return links_; }

  /// Factors the matrix of the equation. Without stiffness, the independent rows of the loops are found; with stiffness, those of the last
  /// factorization without it are used, because stiff links on both sides of a loop make its rows look dependent. Overwrites ws.IA, ws.U,
  /// ws.d. O(links) for loops of bounded size.
  /// @param dependent pivot threshold of dependent rows (closed_links.h)
  /// @param extra [nv] kg | kg m^2, or empty @param stiffness [links] K_i, or empty
  /// @return velocity index of a DOF that moves no inertia, or -1
  [[nodiscard]] int factor(const Mechanism& m, Workspace& ws, double dependent, std::span<const double> extra,
                           std::span<const ArticulatedInertia> stiffness);
  /// Solves the equation for x; call factor() first. Afterwards ws.A contains the velocity changes of the links, J_i x.
  /// @param r [nv] N s | N m s @param wrenches [links] f_i about p0, or empty: zero @param v [nv] velocity before the change
  /// @param closing [rows of all loops] c in m/s | rad/s, or empty: zero @param x [nv, out]; must not alias an input
  void solve(const Mechanism& m, Workspace& ws, std::span<const double> r, std::span<const Vec6> wrenches, std::span<const double> v,
             std::span<const double> closing, std::span<double> x);
  /// Calculates the inverse inertias of all links and DOFs; call factor() first. O(links). @return valid until the next call
  const LinkResponses& calc_responses(const Mechanism& m, Workspace& ws);

 private:
  ClosedLinks links_;
  std::vector<char> rows_;  // [rows of all loops] 1: independent in the last factorization without stiffness
  LinkResponses responses_;
};

}  // namespace ugoki::dynamics
