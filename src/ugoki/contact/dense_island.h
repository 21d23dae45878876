#pragma once
// Solver for the impulses of one small island. It uses the dense inverse inertia B = Y Y^T (velocity_solver.h defines Y and islands).
//
// The velocities of the island's rows are u = target + B p, p being the impulses. Two sweeps solve each block with the others fixed
// (contact_law.h); in most steps they suffice or come near. The semi-smooth Newton method then solves all rows at once. It finds the root
// of the natural map of the laws,
//   f(p) = a B_rr (p - P(p - v / (a B_rr))),   v = u + s p_n for the normal of a contact, v = u for all other rows        [m/s | rad/s]
// P projects onto the bounds of the block's law, s is the compliance, B_rr the inverse inertia of the row and a the augmentation. f = 0 is
// the law itself for every a > 0. With x = p - v / (a B_rr) a contact is open if x_n <= 0, sticks if |x_t| is below r = mu (x_n +
// impact_impulse), and slides otherwise; a limit is active if x > 0. For fixed classes f is linear in the unknowns z of a block:
//   sticking contact   z = (p_n, p_t1, p_t2)                         u_n + s p_n = 0,  u_t = 0
//   sliding contact    z = (p_n, q),  p_t = r d + q e                u_n + s p_n = 0,  u_e + a B_tt (|x_t| / r - 1) q = 0
//   active limit, friction below its bound, roll below its bound     u = 0
// All other blocks take their bound. n is the normal, t1 and t2 are the tangents, d = x_t / |x_t| is the direction of friction, and e is
// the tangent perpendicular to d. The second equation of a sliding contact keeps friction opposed to the slip. A step that does not reduce
// |f| is halved. A last sweep measures the error: the island has converged when a sweep changes no velocity by more than the tolerance.
// Sources: Alart, Curnier (1991), A mixed formulation for frictional contact problems prone to Newton-like methods; Qi, Sun (1993), A
// nonsmooth version of Newton's method; Acary, Brogliato (2008), Numerical methods for nonsmooth dynamical systems, section 13.6.

#include <span>
#include <vector>

#include "ugoki/contact/row_block.h"

namespace ugoki::contact {

/// The rows of one island, in the memory of the velocity solver.
struct IslandRows {
  std::span<const RowBlock> blocks;      ///< row blocks of all islands
  std::span<const int> order;            ///< indices of the island's blocks; a roll block follows the block of its contact
  std::span<const RowSegment> segments;  ///< segments of all islands
  const double* rows = nullptr;          ///< whitened rows of all islands; RowSegment::offset is an index into them
  const double* target = nullptr;        ///< m/s | rad/s: velocities without impulses minus wanted ones; RowBlock::row is an index
  double* p = nullptr;                   ///< N s | N m s; in: impulses to start from, out: solution; indexed like target
};

struct DenseResult {
  int sweeps = 0;
  int newton_steps = 0;
  double change = 0;  ///< m/s: maximum change of a velocity in the sweep that measured the returned impulses
  bool converged = false;
};

/// Solver of small islands. The constructor reserves memory for max_rows rows on chains of up to 64 DOFs.
class DenseIsland {
 public:
  DenseIsland();

  /// Above this number of rows, making B and factoring the Newton matrix cost more than sweeps along the chains of the links.
  static constexpr int max_rows = 96;
  /// m/s: an island whose residual stays above the tolerance is accepted below this limit; a resting contact then creeps 10 um in 1 s.
  static constexpr double accepted_residual = 1e-5;

  /// Solves the island, beginning with the impulses in `island.p`. Without convergence, `island.p` receives the best impulses found.
  /// O(rows^2 chain length) to make B, O(active rows^3) for each Newton step.
  /// @param tolerance m/s: converged when a sweep changes no velocity by more
  DenseResult solve(const IslandRows& island, double tolerance);

 private:
  /// An unknown impulse of a Newton step.
  struct Unknown {
    int row;          // its row; if `tangent` is set, the normal row of its contact
    bool tangent;     // it acts along t1, t2 on the tangential rows of the contact; the unknowns in sliding_ act on the normal row as well
    double t1, t2;    // mu d in sliding_, e in unknowns_ (d, e: top of this file)
    double diagonal;  // added to the matrix diagonal: compliance, slope of the direction of friction, or regularization
    double rest;      // `diagonal` times the present impulse if `diagonal` is a regularization, which then acts on the change only
  };

  void number_rows(const IslandRows& island);
  void make_matrix(const IslandRows& island);
  void update_velocities();
  double sweep(const IslandRows& island, bool forward);
  double residual(const IslandRows& island);
  void collect_unknowns(const IslandRows& island);
  void add_contact(const RowBlock& b, int row);
  void make_equations();
  bool solve_equations();
  bool find_step(const IslandRows& island);
  bool newton_step(const IslandRows& island, double& norm);
  void solve_by_newton(const IslandRows& island, double augmentation, double later, double tolerance, DenseResult& result);
  void project(const IslandRows& island);
  /// N s: p_n + impact_impulse of the contact of a roll block. @param block index of the roll block in the island
  [[nodiscard]] double normal_impulse(std::size_t block) const {
    return p_[static_cast<std::size_t>(local_[block - 1])] + impact_impulse_[block];
  }
  [[nodiscard]] const double* column(int row) const {
    return B_.data() + static_cast<std::size_t>(row) * static_cast<std::size_t>(stride_);
  }

  int n_ = 0, stride_ = 0;              // number of rows; number of entries of a row of B_, with padding
  std::vector<int> local_;              // [blocks of the island] index of the block's first row in the island
  std::vector<double> impact_impulse_;  // [blocks of the island] N s: impact_impulse of the contact of a roll block; other blocks: 0
  std::vector<double> B_;               // [n][stride] inverse inertia Y Y^T, symmetric
  std::vector<double> target_, p_, u_;  // [n] target, impulse and velocity of each row
  std::vector<double> best_p_;          // [n] impulses of the sweep with the smallest velocity change so far
  std::vector<double> fixed_;           // [n] the known part of p after a Newton step
  std::vector<double> fixed_u_;         // [n] velocities at the impulses fixed_
  std::vector<double> made_u_;          // [n] velocity changes by a unit of one unknown
  std::vector<Unknown> unknowns_;       // all but those in sliding_; their part of the matrix is symmetric
  std::vector<Unknown> sliding_;        // normal impulses of sliding contacts, with the friction that they make
  std::vector<double> step_, step_u_;   // [n] Newton step and the velocity change that it causes
  std::vector<double> old_p_, old_u_;   // [n] impulses and velocities before the Newton step
  double augmentation_ = 1;             // a of the natural map (top of this file)
  double max_residual_ = 0;             // m/s: maximum entry of the natural map at the last call of residual()
  // [unknowns][unknowns + 2 sliding + 1]: upper half of the symmetric part, columns of sliding_, their equations' rows as columns, right
  // side
  std::vector<double> A_;
  std::vector<double> S_;        // [sliding][sliding + 1] equations of sliding_, last column: right side
  std::vector<double> z_;        // [unknowns + sliding] solution
  std::vector<double> inverse_;  // [unknowns] inverse pivots
};

}  // namespace ugoki::contact
