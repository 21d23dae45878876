#pragma once
// Closed link systems the paper's way (section 5, 4): the constraint matrix J of all closed loops, its independent rows, and the
// split of the freedoms into theta_G (as many as the system has degrees of freedom) and theta_S, which follow:
//
//   J v = 0,   v_S = -J_S^-1 J_G v_G,   v = H v_G,   H = [E; -J_S^-1 J_G]                        paper eq. (5)
//
// v holds exactly the joints of the cut tree, so the paper's W is H itself; its S are the rows of H of the driven joints.
//
// Rows and columns are chosen by elimination with full pivoting on J in one unit (distances are measured in `length`), and kept
// until an entry of J_S^-1 J_G has grown or a pivot has shrunk too far: then they are chosen anew. The state itself is always
// the whole q and v, so a new choice changes neither. Where the rank drops for an instant (dead points, change points), the rows
// that vanish are left out: the system then has more freedoms, and no small pivot enters anywhere.

#include "ugoki/dynamics/dense.h"
#include "ugoki/dynamics/loop_rows.h"
#include "ugoki/dynamics/workspace.h"

namespace ugoki::dynamics {

/// Caller-owned, sized once from the mechanism, one a thread.
struct ClosedWorkspace {
  explicit ClosedWorkspace(const Mechanism& mechanism) : ClosedWorkspace(mechanism, mechanism.loops()) {}
  /// @param all_loops the mechanism's own, and others that may be closed while running
  ClosedWorkspace(const Mechanism& mechanism, std::span<const Loop> all_loops);

  std::vector<Loop> loops;
  Workspace open;                ///< of the cut tree
  LoopRows rows;                 ///< of all loops
  std::vector<char> closed;      ///< [loops] set by set_closed(); at the start as each loop says
  double length = 1;             ///< m; scale between distances and angles, from the mechanism's dimensions
  double rank_tolerance = 1e-7;  ///< a pivot below this part of the greatest entry counts as zero
  double gap_tolerance = 1e-15;  ///< gaps below this times the extent of the mechanism count as rounding

  double contradiction = 0;  ///< gap that redundant rows kept when the loops were closed (frames that do not quite agree)

  // The choice: update_partition()
  int full_rank = -1;              ///< rank in general position, find_full_rank(); -1: not known, the rank is not limited
  double full_pivot_part = 0;      ///< pivot_part in general position
  int rank = -1;                   ///< freedoms in theta_S; -1: no choice yet
  double pivot_part = 1;           ///< least pivot of J_S over the greatest: its distance from a singular position
  bool hold_choice = false;        ///< within a step the choice changes only where J_S has no inverse
  bool chosen_anew = false;        ///< the last update changed the choice
  std::vector<int> active;         ///< rows of the closed loops, indices into `rows`
  std::vector<int> row_order;      ///< [active] the first `rank` are independent; indices into `active`
  std::vector<int> freedom_order;  ///< [nv] the first `rank` are theta_S, the rest theta_G

  // Left by update_partition()
  std::vector<double> J;              ///< [active * nv] in one unit: rows times row_scale, columns times freedom_scale
  std::vector<double> row_scale;      ///< [rows] 1 for angles, 1 / length for distances
  std::vector<double> freedom_scale;  ///< [nv] 1 for angles, length for distances
  LuFactor J_S;                       ///< [rank * rank] of the independent rows, in one unit
  std::vector<double> H;              ///< [nv * freedoms()] v = H v_G, columns as in theta_G(), in the units of v

  // Left by update_closed()
  std::vector<double> products;  ///< [rows] dJ/dt v
  std::vector<double> h;         ///< [nv] dH/dt v_G: the accelerations that the loops enforce when theta_G has none

  // Scratch
  std::vector<double> pivots, K, q1, v1, q2, v2, q3, v3, vdot1, vdot2, tau1, column, A_G, b_G, normal, multipliers, step, branch;
  std::vector<Vec6> rest_V, rest_C;  ///< [links] zeros
  std::vector<int> kept_rows, kept_freedoms;
  double keep_limit = 0;

  [[nodiscard]] int freedoms() const { return static_cast<int>(freedom_order.size()) - rank; }  ///< degrees of freedom here
  [[nodiscard]] std::span<const int> theta_S() const { return std::span(freedom_order).first(static_cast<std::size_t>(rank)); }
  [[nodiscard]] std::span<const int> theta_G() const { return std::span(freedom_order).subspan(static_cast<std::size_t>(rank)); }
  [[nodiscard]] bool is_singular() const { return rank < full_rank; }  ///< a dead point or change point
  [[nodiscard]] bool is_nearly_singular() const { return is_singular() || pivot_part < 0.02 * full_pivot_part; }
};

/// Closes or opens a loop; the choice is made anew at the next update. Positions are not changed.
void set_closed(const Mechanism& m, ClosedWorkspace& cw, int loop, bool closed);

/// J alone, from what update_kinematics() and update_loop_rows() left. O(rows nv)
void update_constraint_matrix(const Mechanism& m, ClosedWorkspace& cw);

/// J, the choice and H, from what update_kinematics() and update_loop_rows() left. O(rows nv rank), less while the choice is kept.
void update_partition(const Mechanism& m, ClosedWorkspace& cw);

/// Kinematics, gaps, J, the choice, H and h at a configuration whose loops are closed.
/// @param v [nv] with J v = 0 (see close_velocities)
void update_closed(const Mechanism& m, std::span<const double> q, std::span<const double> v, ClosedWorkspace& cw);

/// v_S <- -J_S^-1 J_G v_G: what theta_G does decides the rest.
void apply_partition(const ClosedWorkspace& cw, std::span<double> v);

/// x_G = H^T x: joint forces of all freedoms -> those of theta_G (paper eq. (3)). @param x_G [freedoms, out]
void reduce_forces(const ClosedWorkspace& cw, std::span<const double> x, std::span<double> x_G);

/// True where the freedom is a distance, not an angle.
[[nodiscard]] bool is_distance(const Joint& joint, int freedom_of_joint);

}  // namespace ugoki::dynamics
