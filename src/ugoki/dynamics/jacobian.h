#pragma once
// Jacobians of links and points, and their time derivatives. Call update_kinematics() first.
//
// A Jacobian is stored as one column for each DOF of the link's chain (chain_of_link(), root first): V = sum over k of J[k] v[chain[k]].
// expand_columns() writes it as a full 6 x nv matrix. Nothing here allocates. O(depth) unless stated otherwise.
// Source: Featherstone, Rigid Body Dynamics Algorithms (2008), ch. 2 and 4.

#include "ugoki/dynamics/workspace.h"

namespace ugoki::dynamics {

/// Axes and reference point in which a link's velocity is expressed.
enum class JacobianFrame {
  world,  ///< world axes; linear part: velocity of the link's point at p_W
  body,   ///< the link's axes; linear part: velocity of the link's origin
};

/// True if the axis S of DOF k of this joint type is constant in the link's frame B; false if it is constant in the joint's frame J.
/// For the DOFs j of the same joint, dS/dq_j = S_j x S in the first case and 0 in the second. For the DOFs j of ancestors,
/// dS/dq_j = S_j x S for both kinds of axes.
[[nodiscard]] bool axis_moves_with_link(JointType type, int k);

/// Time derivatives dS/dt of the motion subspaces, in world axes about the point p0, which is regarded as fixed in the world. O(links).
/// @param S_dot [nv, out]
void calc_subspace_rates(const Mechanism& m, const Workspace& ws, std::span<Vec6> S_dot);

/// Jacobian of `link`.
/// @param p_W m: the point for JacobianFrame::world (ws.X_WB[link].p for the link's origin); ignored for JacobianFrame::body
/// @param columns [chain length, out]
void calc_jacobian(const Workspace& ws, int link, JacobianFrame frame, const Vec3& p_W, std::span<Vec6> columns);

/// Time derivative J_dot of calc_jacobian(); the point p_W moves with the link: dV/dt = J vdot + J_dot v. For JacobianFrame::body, dV/dt
/// is the derivative of the components in the link's axes.
/// @param S_dot [nv] from calc_subspace_rates() @param columns [chain length, out]
void calc_jacobian_rate(const Workspace& ws, std::span<const Vec6> S_dot, int link, JacobianFrame frame, const Vec3& p_W,
                        std::span<Vec6> columns);

/// Product J_dot v of calc_jacobian_rate(), computed without the matrix. O(depth). @return rad/s^2, m/s^2
[[nodiscard]] Vec6 calc_jacobian_bias(const Mechanism& m, const Workspace& ws, int link, JacobianFrame frame, const Vec3& p_W);

/// Jacobian of the velocity of link b relative to link a, in the axes of a. Its linear part is the velocity of the point of b at p_W [m].
/// Index -1 means the world. One column for every DOF. O(nv). @param J [6 * nv, out] row by row, angular rows first
void calc_relative_jacobian(const Workspace& ws, int a, int b, const Vec3& p_W, std::span<double> J);
/// Time derivative of calc_relative_jacobian(). @param S_dot [nv] from calc_subspace_rates() @param J_dot [6 * nv, out]
void calc_relative_jacobian_rate(const Workspace& ws, std::span<const Vec6> S_dot, int a, int b, const Vec3& p_W, std::span<double> J_dot);

/// Writes the columns of a link's chain as a full matrix.
/// @param columns [chain length] @param J [6 * nv, out] row by row, angular rows first
void expand_columns(const Workspace& ws, int link, std::span<const Vec6> columns, std::span<double> J);

}  // namespace ugoki::dynamics
