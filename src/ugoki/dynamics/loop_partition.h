#pragma once
// Closed link systems by the paper's method (Nagashima 1999, section 5, 4): the constraint matrix J of all closed loops, its
// independent rows, and the partition of the DOFs into independent ones, theta_G (as many as the system has degrees of freedom), and
// dependent ones, theta_S:
//
//   J v = 0,   v_S = -J_S^-1 J_G v_G,   v = H v_G,   H = [E; -J_S^-1 J_G]                        paper eq. (5)
//
// E is the identity matrix. v contains exactly the joints of the cut tree, so the paper's W is H itself. The paper's S consists of the
// rows of H that belong to driven joints.
//
// The independent rows and theta_S are called the choice. The choice is made by elimination with full pivoting on J, scaled to one unit
// (distances in units of `length`). The choice is kept until an entry of J_S^-1 J_G becomes too large or a pivot too small; then a
// new choice is made. The state is always the full q and v, so a new choice does not change the state. Where the rank drops for an
// instant (dead points, change points), the dependent rows are left out: the system then has more degrees of freedom, and no small
// pivot is used.

#include "ugoki/dynamics/dense.h"
#include "ugoki/dynamics/loop_rows.h"
#include "ugoki/dynamics/workspace.h"

namespace ugoki::dynamics {

/// Data and scratch memory of the functions for closed link systems. Owned by the caller, sized at construction; one per thread.
struct ClosedWorkspace {
  explicit ClosedWorkspace(const Mechanism& mechanism) : ClosedWorkspace(mechanism, mechanism.loops()) {}
  /// @param all_loops the mechanism's own loops, and further loops that may be closed later
  ClosedWorkspace(const Mechanism& mechanism, std::span<const Loop> all_loops);

  std::vector<Loop> loops;
  Workspace open;                ///< workspace of the cut tree
  LoopRows rows;                 ///< rows of all loops, open ones included
  std::vector<char> closed;      ///< [loops] set by set_closed(); initially Loop::closed
  double length = 1;             ///< m; unit of distances that makes them comparable with angles: mean offset between joints
  double rank_tolerance = 1e-7;  ///< a pivot below this fraction of the maximum entry of J counts as zero
  double gap_tolerance = 1e-15;  ///< gaps below this fraction of the mechanism's extent count as rounding error

  double contradiction = 0;  ///< root sum of squares of the scaled gaps that remained in closed loops (slightly misaligned frames)

  // The choice, made by update_partition()
  int full_rank = -1;           ///< rank in general position, from find_full_rank(); -1: unknown, the rank is not limited
  double full_pivot_ratio = 0;  ///< pivot_ratio in general position
  int rank = -1;                ///< number of DOFs in theta_S; -1: no choice yet
  double pivot_ratio = 1;       ///< minimum pivot of J_S divided by the maximum; tends to 0 towards a singular configuration
  bool hold_choice = false;     ///< true during an integration step: the choice changes only if J_S is singular
  bool rechosen = false;        ///< true: the last update_partition() changed the choice
  std::vector<int> active;      ///< rows of the closed loops, indices into `rows`
  std::vector<int> row_order;   ///< [active] the first `rank` are independent; indices into `active`
  std::vector<int> dof_order;   ///< [nv] the first `rank` are theta_S, the rest theta_G

  // Results of update_partition()
  std::vector<double> J;          ///< [active * nv] constraint matrix scaled to one unit: rows times row_scale, columns times dof_scale
  std::vector<double> row_scale;  ///< [rows] 1 for an angle, 1 / (length of the mechanism [m]) for a distance
  std::vector<double> dof_scale;  ///< [nv] 1 for an angle, the length of the mechanism [m] for a distance
  LuFactor J_S;                   ///< [rank * rank] independent rows, columns of theta_S, scaled to one unit
  std::vector<double> H;          ///< [nv * dofs()] v = H v_G; columns ordered as theta_G(), in the units of v

  // Results of update_closed()
  std::vector<double> products;  ///< [rows] velocity products dJ/dt v: m/s^2 | rad/s^2
  std::vector<double> h;         ///< [nv] dH/dt v_G: accelerations that the loops enforce when theta_G has zero acceleration

  // Scratch
  std::vector<double> pivots, K, q1, v1, q2, v2, q3, v3, vdot1, vdot2, tau1, column, A_G, b_G, normal, multipliers, step, branch;
  std::vector<Vec6> rest_V, rest_C;  ///< [links] zeros: velocities and velocity products at rest
  std::vector<int> kept_rows, kept_dofs;
  double keep_limit = 0;  // the choice is kept while all entries of J_S^-1 J_G are below this bound

  [[nodiscard]] int dofs() const { return static_cast<int>(dof_order.size()) - rank; }  ///< degrees of freedom at the present configuration
  [[nodiscard]] std::span<const int> theta_S() const { return std::span(dof_order).first(static_cast<std::size_t>(rank)); }
  [[nodiscard]] std::span<const int> theta_G() const { return std::span(dof_order).subspan(static_cast<std::size_t>(rank)); }
  [[nodiscard]] bool is_singular() const { return rank < full_rank; }  ///< true at a dead point or change point
  /// True at or near a singular configuration: pivot_ratio below 2 % of full_pivot_ratio. update_partition() then tries a new choice.
  [[nodiscard]] bool is_nearly_singular() const { return is_singular() || pivot_ratio < 0.02 * full_pivot_ratio; }
};

/// Closes or opens a loop. The next update makes a new choice; positions do not change.
void set_closed(const Mechanism& m, ClosedWorkspace& cw, int loop, bool closed);

/// Computes J from the last results of update_kinematics() and update_loop_rows(). O(rows nv)
void update_constraint_matrix(const Mechanism& m, ClosedWorkspace& cw);

/// Computes J, the choice and H from the last results of update_kinematics() and update_loop_rows(). O(rows nv rank), less while
/// the choice is kept.
void update_partition(const Mechanism& m, ClosedWorkspace& cw);

/// Computes kinematics, gaps, J, the choice, H and h at a configuration whose loops are closed.
/// @param v [nv] m/s | rad/s, with J v = 0 (see close_velocities)
void update_closed(const Mechanism& m, std::span<const double> q, std::span<const double> v, ClosedWorkspace& cw);

/// v_S <- -J_S^-1 J_G v_G: replaces the dependent velocities by those that follow from v_G. @param v [nv, in/out]
void apply_partition(const ClosedWorkspace& cw, std::span<double> v);

/// x_G = H^T x: reduces the joint forces of all DOFs to generalised forces on theta_G (paper eq. (3)). @param x_G [dofs(), out]
void reduce_forces(const ClosedWorkspace& cw, std::span<const double> x, std::span<double> x_G);

/// True if the DOF is a distance, false if it is an angle.
[[nodiscard]] bool is_distance(const Joint& joint, int dof_of_joint);

}  // namespace ugoki::dynamics
