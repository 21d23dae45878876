#pragma once
// Constraint rows (scalar equations) of loops: gaps, velocity rows and velocity products (Nagashima 1999, section 5: J(q) q' = 0).
//
// Row k of a loop between links a and b requires  w_k . (V_b - V_a) = 0.  The wrench w_k is about the reference point p0, in world
// axes. A unit multiplier exerts w_k on link b and -w_k on link a. J_A and J_B are the loop joint's frames on links a and b, p_A
// and p_B their origins, p = p_B - p_A, R_AB the rotation of J_B in J_A, e an axis fixed in J_A, and a_B an axis fixed in J_B:
//
//   rows                          gap                      w (moment; force)
//   p . e = 0                     e . (p_B - p_A)          (p_B - p0) x e; e
//   R_AB = 1, about e             log(R_AB) . e            e; 0
//   a_B perpendicular to e        e . a_B                  a_B x e; 0
//   |p| = length                  |p_B - p_A| - length     (p_B - p0) x n; n: unit vector along p
//
// A gear's row  x_a - c(x_b) = 0  acts directly on the displacements x_a, x_b of two DOFs. Its velocity row is v_a - c'(x_b) v_b, and
// w = 0. The polynomial c is Loop::polynomial.

#include <span>
#include <string_view>
#include <vector>

#include "ugoki/dynamics/workspace.h"

namespace ugoki::dynamics {

/// Constraint rows of a list of loops. The rows of one loop are consecutive.
struct LoopRows {
  explicit LoopRows(std::span<const Loop> loops);

  std::vector<int> first;     ///< [loops + 1] first row of each loop
  std::vector<Vec6> W;        ///< [rows] wrenches w about p0, world axes, moment first; zero for gears
  std::vector<double> gap;    ///< [rows] m | rad | 1 (cosine of the angle between axes); gears: unit of DOF a
  std::vector<double> drift;  ///< [rows] (dw/dt) . (V_b - V_a); gears: -c'' v_b^2
  std::vector<double> slope;  ///< [loops] gears: c'(x_b); other loops: not used

  [[nodiscard]] int count() const { return first.back(); }
};

/// Computes the rows of all loops, open ones included, from the last results of update_kinematics() in `ws`.
/// @param q, v [nq], [nv] the state given to update_kinematics()
void update_loop_rows(const Mechanism& m, const Workspace& ws, std::span<const Loop> loops, std::span<const double> q,
                      std::span<const double> v, LoopRows& rows);

/// Computes the rows of all loops from the poses and velocities of their links. Elements of X_WB and V for other links are not read.
/// @param p0 m, world: reference point of the wrenches and of V
/// @param X_WB, V [links] poses in the world; spatial velocities about p0, world axes
/// @param gaps false: rotation gaps are not computed (they become 0), which saves time
void update_loop_rows(const Mechanism& m, const Vec3& p0, std::span<const Pose> X_WB, std::span<const Vec6> V, std::span<const Loop> loops,
                      std::span<const double> q, std::span<const double> v, bool gaps, LoopRows& rows);

/// Computes row r of loop i as a row J of the constraint matrix: J v = w . (V_b - V_a). @param J [nv, out]. O(nv)
void calc_loop_jacobian_row(const Mechanism& m, const Workspace& ws, const Loop& loop, const LoopRows& rows, int i, int r,
                            std::span<double> J);

/// Computes the velocity product dJ/dt v of every row; the acceleration of the row is J vdot + dJ/dt v. Overwrites ws.A. O(links)
/// @param products [rows, out] m/s^2 | rad/s^2
void calc_loop_velocity_products(const Mechanism& m, Workspace& ws, std::span<const Loop> loops, const LoopRows& rows,
                                 std::span<double> products);

/// Name of the motion that row r of a loop prevents, for messages: "translation along x", "rotation about y", "distance". x, y and z are
/// the axes of J_A.
[[nodiscard]] std::string_view row_name(LoopType type, int r);

}  // namespace ugoki::dynamics
