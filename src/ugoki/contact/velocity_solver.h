#pragma once
// Velocity solver: the impulses of all contacts, joint limits and dry friction of a step.
//
// Whitened row: a constraint row J is stored as y = D^-1/2 L^-T J^T, where M' = L^T D L is the inertia matrix of a system. The whitened
// velocity of a system is w = D^1/2 L (v - v_free), v_free being the velocity without impulses. In these coordinates
//   u = J v - wanted = target + y . w,   w = sum of y p over all rows,   |w|^2 / 2 = kinetic energy of the velocity change [J]
// so that the solver needs no masses. u is in m/s or rad/s, p in N s or N m s, y in 1/sqrt(kg) or 1/sqrt(kg m^2).
//
// The impulses p satisfy the law of each block (contact_law.h).
//
// An island is a group of systems joined by rows; islands are solved independently, each by the first of these methods that converges:
//   1. Small islands: sweeps and semi-smooth Newton steps on the dense matrix B = Y Y^T (dense_island.h).
//   2. Sweeps: each visits the blocks of the island one after the other (block Gauss-Seidel) and solves each block by itself.
//   3. If sweeps converge slowly (heavy bodies on light ones, towers): semi-smooth Newton steps on w, once. Their sparse matrix couples
//      only systems that touch (envelope, breadth-first order). See velocity_semismooth.cpp.
//   4. If the sweeps still converge slowly: Newton's method on w for the augmented Lagrangian, with the same envelope. See
//      velocity_newton.cpp.
//   5. Where 16 steps of method 3 exceed the bound of an island's work: sweeps, and method 4 for the systems whose velocities still change,
//      to a fifth of SolverOptions::coarse.
// Sources: Moreau (1988), Unilateral contact and dry friction in finite DOF dynamics; Hwangbo, Lee, Hutter (2018), Per-contact
// iteration method; Alart, Curnier (1991), A mixed formulation for frictional contact problems prone to Newton-like methods.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "ugoki/base/executor.h"
#include "ugoki/contact/dense_island.h"
#include "ugoki/contact/envelope_matrix.h"
#include "ugoki/contact/natural_map.h"
#include "ugoki/contact/row_block.h"
#include "ugoki/contact/system_order.h"

namespace ugoki::contact {

struct SolverOptions {
  int iterations = 60;      ///< maximum number of sweeps over an island
  double tolerance = 1e-7;  ///< m/s: an island has converged when no velocity changes by more in a sweep
  double coarse = 0.05;     ///< m/s: tolerance of islands of more than 256 blocks; a fifth of it where Newton's method is too expensive
  double softness = 1e-4;   ///< minimum of RowBlock::softness for contacts; redundant contacts then share their load
  int max_dense_rows = DenseIsland::max_rows;  ///< islands of more rows are solved without method 1
};

struct SolverReport {
  int islands = 0;        ///< number of islands solved
  int sweeps = 0;         ///< maximum number of sweeps over one island
  int newton_steps = 0;   ///< Newton steps, summed over all islands
  int handed_over = 0;    ///< small islands for which method 1 (dense matrix) did not converge
  int not_converged = 0;  ///< islands with a residual above tolerance and accepted_residual (DenseIsland), also if not solved again
  double residual = 0;    ///< m/s: maximum change of a velocity in the last sweep
};

/// Scenes with fewer DOFs are stepped on one thread, because the threads of a pool need 5 to 20 us to begin and end. In this time, one
/// thread can step a scene with 50 DOFs and contacts.
inline constexpr std::size_t min_parallel_dofs = 256;

/// Solves the impulses of one step; see the equations at the top of this file. Keeps its memory from step to step.
class VelocitySolver {
 public:
  VelocitySolver();
  VelocitySolver(VelocitySolver&&) noexcept;
  VelocitySolver& operator=(VelocitySolver&&) noexcept;
  ~VelocitySolver();

  /// Sets the systems. @param first [systems + 1] index in w of the first DOF of each system; the last entry is the total number of DOFs
  void set_systems(std::span<const int> first);
  /// Solves islands on the threads of `executor`; null: on the calling thread. The impulses have the same bits in both cases.
  void set_executor(Executor* executor);

  /// Removes all rows and sets w to zero.
  void clear();

  // To add a block: begin_block(), then add_segment() once or twice and fill its rows, then end_block(), or drop_block() to discard it.
  RowBlock& begin_block(RowKind kind, std::uint64_t key);
  /// @param index [length] see RowSegment::index; must stay valid until clear()
  /// @return [length][4] memory for the whitened rows, one lane a row, to be filled by the caller; unused lanes must be zero. Valid until
  /// the next call
  std::span<double> add_segment(int system, const int* index, int length);
  /// [length][4] whitened rows of the last segment.
  [[nodiscard]] std::span<double> last_segment() { return std::span(rows_).subspan(static_cast<std::size_t>(segments_.back().offset)); }
  /// @param target [rows] m/s | rad/s: velocity without impulses minus the wanted velocity
  /// @param warm   [rows] impulses to start from; empty: zero
  void end_block(std::span<const double> target, std::span<const double> warm);
  void drop_block();

  /// Limits the work of Newton's method in all following solutions together, until the next call. Initially only the work for each
  /// island in each solution is limited. At the limit, large or difficult islands are solved by sweeps alone.
  /// @param operations estimated number of floating-point operations
  void limit_newton(double operations) { newton_left_ = operations; }

  SolverReport solve(const SolverOptions& options);
  /// Solves only the islands that contain a new block, starting from the present impulses. Call it after solve(), when blocks were added.
  /// @param first_new index of the first new block
  SolverReport solve_again(const SolverOptions& options, std::size_t first_new);
  /// Whether the last solve() or solve_again() may have changed w of a system.
  [[nodiscard]] bool is_solved(int system) const { return solved_[static_cast<std::size_t>(system)] != 0; }

  [[nodiscard]] std::span<const RowBlock> blocks() const { return blocks_; }
  [[nodiscard]] std::span<const double> impulses() const { return p_; }
  [[nodiscard]] std::span<const double> impulses(const RowBlock& b) const {
    return std::span(p_).subspan(static_cast<std::size_t>(b.row), static_cast<std::size_t>(b.rows));
  }
  /// [nv] whitened velocity change w of one system, after solve().
  [[nodiscard]] std::span<const double> w(int system) const {
    const auto s = static_cast<std::size_t>(system);
    return std::span(w_).subspan(static_cast<std::size_t>(first_[s]), static_cast<std::size_t>(first_[s + 1] - first_[s]));
  }

 private:
  struct Island {
    int first_block, blocks;    // the island's blocks: a range of order_
    int first_system, systems;  // its systems: a range of members_
  };

  struct SortedRows {
    int first, length;  // the block's entries: a range of z_row_ and z_run_
    int values;         // index in z_ of its rows [rows][length]
  };

  /// Block i of an island.
  [[nodiscard]] RowBlock& block(const Island& island, int i) {
    return blocks_[static_cast<std::size_t>(order_[static_cast<std::size_t>(island.first_block + i)])];
  }
  void velocities(const RowBlock& b, double* u) const;
  void apply(const RowBlock& b, const double* p);
  double sweep(const Island& island, bool forward, double minimum);
  void begin_blocks(const SolverOptions& options, std::size_t first);
  void find_islands();
  void copy_island(const VelocitySolver& from, const Island& island);
  void copy_solution_to(VelocitySolver& to, const Island& island) const;
  void solve_on_threads(const SolverOptions& options, SolverReport& report);
  bool solve_island(const Island& island, const SolverOptions& options, SolverReport& report);
  bool solve_densely(const Island& island, const SolverOptions& options, double tolerance, SolverReport& report);

  // Newton's method, in velocity_newton.cpp
  int newton_on_subset(const Island& island, double tolerance);
  bool order_systems(const Island& island, int steps);
  [[nodiscard]] int matrix_row(const RowSegment& x, int e) const;
  int newton(const Island& island, bool subset, double change, double tolerance);
  void fix_law(const Island& island);
  int minimise(const Island& island);
  void sort_rows(const Island& island);
  std::pair<double, double> apply_laws(const Island& island, double length);
  void calc_residual(const Island& island);
  void assemble_matrix(const Island& island);
  void recompute_w(const Island& island);

  // Semi-smooth Newton method, in velocity_semismooth.cpp
  int semi_smooth_newton(const Island& island, double change, double tolerance);
  void project(const Island& island);
  [[nodiscard]] double leader_impulse(const RowBlock& b) const;
  void update_motion(const Island& island);
  void velocities_at(const Island& island, int i, const std::vector<double>& x, double* u);
  double natural_map(const Island& island, double augmentation, double& maximum);
  bool step_to_linear_laws(const Island& island, double augmentation);

  // Threads, in velocity_threads.cpp
  struct Worker;
  Executor* executor_ = nullptr;
  std::vector<std::unique_ptr<Worker>> workers_;
  std::vector<int> to_solve_;  // indices in islands_ of the islands to solve
  std::vector<double> used_;   // [to_solve_] floating-point operations that Newton's method used for each of these islands

  DenseIsland dense_;
  std::vector<int> first_;  // [systems + 1] index in w_ of the first DOF of each system
  std::vector<RowBlock> blocks_;
  std::vector<RowSegment> segments_;
  std::vector<double> rows_;
  std::vector<double> target_, p_;
  std::vector<double> w_;
  std::vector<double> motion_;  // [systems] upper bound of the sum of |change of w| over the sweeps so far

  // Islands
  std::vector<int> root_;     // [systems] union-find parents
  std::vector<int> island_;   // [systems] index of the system's island
  std::vector<int> order_;    // block indices, sorted by island
  std::vector<int> members_;  // system indices, sorted by island
  std::vector<int> cursor_;
  std::vector<Island> islands_;
  std::vector<char> solved_;  // [systems] 1: see is_solved()
  std::vector<char> failed_;  // [systems] 1: the system is the first of an island that is not solved to the tolerance

  // Newton's method (symbols: velocity_newton.cpp)
  double regularization_ = 0;                // R relative to a block's inverse inertia
  double budget_ = 0, cost_ = 0;             // floating-point operations: left for the present island; needed by one Newton step
  double island_budget_ = 0;                 // floating-point operations that Newton's method may use for each island in one call
  double newton_left_ = HUGE_VAL;            // floating-point operations left for all islands until the next limit_newton()
  std::vector<int> local_;                   // [systems] first row of the system in H_
  EnvelopeMatrix H_;                         // Newton matrix H
  std::vector<LinearLaw> laws_;              // [blocks of the island]
  std::vector<double> G_;                    // [blocks of the island * 9] -dp/du, row by row
  std::vector<double> F_, step_, x_;         // [n] x_: w without base_
  std::vector<double> old_p_, hat_, shift_;  // hat_: p^ of the augmented Lagrangian; shift_: AugmentedLaw::shift
  std::vector<double> u_, du_;               // [blocks of the island * 3] velocity, and its change along step_
  std::vector<SortedRows> sorted_;           // [blocks of the island] see sort_rows()
  std::vector<double> z_, swap_;             // z_: the blocks' rows; swap_: scratch
  std::vector<int> z_row_, z_run_;  // matrix row of each entry; end, in its block, of the run of consecutive matrix rows that contains it
  std::vector<double> base_;        // [DOFs] contribution to w_ of blocks outside the solved subset
  std::vector<double> scratch_w_;
  std::vector<char> in_subset_;  // [systems] 1: newton_on_subset() solves the system
  SystemOrder systems_;          // order of the systems in H_
};

}  // namespace ugoki::contact
