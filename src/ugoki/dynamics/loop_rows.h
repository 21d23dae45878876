#pragma once
// Rows of the loops' conditions: gaps, velocity rows and velocity products (paper, section 5: J(q) q' = 0).
//
// Row k of a loop between links a and b says  w_k . (V_b - V_a) = 0:  w_k is a wrench about the reference point p0 in world
// axes, the one with which a unit multiplier acts on link b, and its opposite on link a. With p_B the origin of J_B, e an axis
// fixed in J_A, and a_B an axis fixed in J_B:
//
//   rows                          gap                      w (moment; force)
//   p . e = 0                     e . (p_B - p_A)          (p_B - p0) x e; e
//   R = 1, about e                log(R_AB) . e            e; 0
//   axis a_B at right angle to e  e . a_B                  a_B x e; 0
//   |p| = length                  |p_B - p_A| - length     (p_B - p0) x n; n along p_B - p_A
//
// A gear's row  x_a - c(x_b) = 0  acts on the freedoms themselves: v_a - c'(x_b) v_b, and w = 0.

#include <span>
#include <string_view>
#include <vector>

#include "ugoki/dynamics/workspace.h"

namespace ugoki::dynamics {

struct LoopRows {
  explicit LoopRows(std::span<const Loop> loops);

  std::vector<int> first;     ///< [loops + 1] first row of each loop
  std::vector<Vec6> W;        ///< [rows] zero for gears
  std::vector<double> gap;    ///< [rows] m | rad | 1 (cosine of axes); gears: units of freedom a
  std::vector<double> drift;  ///< [rows] (dw/dt) . (V_b - V_a); gears: -c'' v_b^2
  std::vector<double> slope;  ///< [loops] gears: c'(x_b)

  [[nodiscard]] int count() const { return first.back(); }
};

/// Rows of all loops, open ones too, at what update_kinematics() left in `ws`.
/// @param q, v [nq], [nv] the same as given there
void update_loop_rows(const Mechanism& m, const Workspace& ws, std::span<const Loop> loops, std::span<const double> q,
                      std::span<const double> v, LoopRows& rows);

/// The same from the motion of the loops' own links; the others' are not looked at. @param p0 [m] the point that wrenches and V are about
/// @param X_WB, V [links] poses; velocities in world axes @param gaps false: gaps are left as they are, which saves time
void update_loop_rows(const Mechanism& m, const Vec3& p0, std::span<const Pose> X_WB, std::span<const Vec6> V, std::span<const Loop> loops,
                      std::span<const double> q, std::span<const double> v, bool gaps, LoopRows& rows);

/// Row r of loop `i` over all freedoms: J with J v = w . (V_b - V_a). @param J [nv, out]. O(nv)
void calc_loop_jacobian_row(const Mechanism& m, const Workspace& ws, const Loop& loop, const LoopRows& rows, int i, int r,
                            std::span<double> J);

/// c'' = J vdot + (what this writes): the velocity products dJ/dt v of every row.
/// @param products [rows, out]. Uses ws.A as scratch. O(links)
void calc_loop_velocity_products(const Mechanism& m, Workspace& ws, std::span<const Loop> loops, const LoopRows& rows,
                                 std::span<double> products);

/// What row r of a loop forbids, for people: "translation along x", "rotation about y", "distance" ...; axes of J_A.
[[nodiscard]] std::string_view row_name(LoopType type, int r);

}  // namespace ugoki::dynamics
