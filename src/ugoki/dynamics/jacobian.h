#pragma once
// Jacobians of links and points, and their time derivatives, after update_kinematics().
//
// A Jacobian comes as one column for each freedom of a chain (chain_of_link() of the link, root first): V = sum J[k] v[chain k].
// expand_columns() writes it as a full 6 x nv matrix. Nothing here allocates. O(depth) unless said otherwise.
// Source: Featherstone, Rigid Body Dynamics Algorithms (2008), ch. 2 and 4.

#include "ugoki/dynamics/workspace.h"

namespace ugoki::dynamics {

/// Axes and reference point in which a link's velocity is written.
enum class JacobianFrame {
  world,  ///< world axes; linear part: velocity of the chosen point, which is fixed in the link
  body,   ///< the link's axes; linear part: velocity of the link's origin
};

/// True if the axis S of freedom k of such a joint is constant in the link's frame B, false if it is constant in the joint's
/// frame J. In the first case dS/dq_j = S_j x S for the joint's freedoms j, in the second it is 0; freedoms j of ancestors always
/// give S_j x S.
[[nodiscard]] bool axis_moves_with_link(JointType type, int k);

/// Rates of the motion subspaces, world axes about the point p0 taken as fixed: dS/dt. O(links). @param S_dot [nv, out]
void calc_subspace_rates(const Mechanism& m, const Workspace& ws, std::span<Vec6> S_dot);

/// Jacobian of `link`. @param p_W the point of JacobianFrame::world [m] (ws.X_WB[link].p for the link's origin); not read for body
/// @param columns [chain length, out]
void calc_jacobian(const Workspace& ws, int link, JacobianFrame frame, const Vec3& p_W, std::span<Vec6> columns);

/// Time derivative of the same Jacobian, the point moving with the link: dV/dt = J vdot + J_dot v. With JacobianFrame::body it is
/// the rate of the components in the link's axes.
/// @param S_dot [nv] from calc_subspace_rates
void calc_jacobian_rate(const Workspace& ws, std::span<const Vec6> S_dot, int link, JacobianFrame frame, const Vec3& p_W,
                        std::span<Vec6> columns);

/// J_dot v of the same, without the matrix. O(depth). @return rad/s^2, m/s^2
[[nodiscard]] Vec6 calc_jacobian_bias(const Mechanism& m, const Workspace& ws, int link, JacobianFrame frame, const Vec3& p_W);

/// Velocity of link b relative to link a as seen by a: axes of a, linear part at the point p_W [m], which is fixed in b. Either index may
/// be -1, the world. The columns are those of all freedoms. O(nv). @param J [6 * nv, out] row by row, angular rows first
void calc_relative_jacobian(const Workspace& ws, int a, int b, const Vec3& p_W, std::span<double> J);
/// Its time derivative. @param S_dot [nv] from calc_subspace_rates
void calc_relative_jacobian_rate(const Workspace& ws, std::span<const Vec6> S_dot, int a, int b, const Vec3& p_W, std::span<double> J_dot);

/// Columns of a link's chain as a full matrix. @param J [6 * nv, out] row by row, angular rows first
void expand_columns(const Workspace& ws, int link, std::span<const Vec6> columns, std::span<double> J);

}  // namespace ugoki::dynamics
