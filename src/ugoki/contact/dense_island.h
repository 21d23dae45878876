#pragma once
// Impulses of one small island by its dense inverse inertia B = Y Y^T (velocity_solver.h defines Y and islands).
//
// The velocities of the island are u = target + B p. Two sweeps over the blocks, each block solved with the others fixed
// (contact_law.h), classify the blocks: contacts open, sticking or sliding, limits active or not. A Newton step then solves all active
// rows at once. For fixed classes the laws are linear in the unknowns z of a block:
//   sticking contact   z = (p_n, p_t1, p_t2)                         u_n + s p_n = 0,  u_t = 0
//   sliding contact    z = (p_n, q),  p_t = mu (p_n + impact_impulse) d + q e     u_n + s p_n = 0,  u_e + (|u_t| / (mu p_n)) q = 0
//   active limit, friction below its bound, roll below its bound     u = 0
// All other blocks keep their impulses. d is the direction of friction, e is perpendicular to d; the second equation of a sliding contact
// keeps friction opposed to the slip. This is one step of the semi-smooth Newton method for the projection form of Coulomb's law.
// The result is projected onto the bounds of the laws and measured by another sweep. The island has converged when a sweep changes no
// velocity by more than the tolerance.
// Sources: Alart, Curnier (1991), A mixed formulation for frictional contact problems prone to Newton-like methods; Qi, Sun (1993), A
// nonsmooth version of Newton's method.

#include <span>
#include <vector>

#include "ugoki/contact/row_block.h"

namespace ugoki::contact {

/// The rows of one island, in the memory of the velocity solver.
struct IslandRows {
  std::span<const RowBlock> blocks;      ///< of all islands
  std::span<const int> order;            ///< indices of the island's blocks; a roll block follows the block of its contact
  std::span<const RowSegment> segments;  ///< of all islands
  const double* rows = nullptr;          ///< whitened rows, see RowSegment::offset
  const double* target = nullptr;        ///< m/s | rad/s, see RowBlock::row
  double* p = nullptr;                   ///< N s | N m s; in: impulses to start from, out: solution
};

struct DenseResult {
  int sweeps = 0;
  int newton_steps = 0;
  double change = 0;  ///< m/s: maximum change of a velocity in the sweep that measured the returned impulses
  bool converged = false;
};

/// Solver of small islands. Keeps its memory, which suffices for max_rows rows on chains of up to 64 DOFs from the beginning.
class DenseIsland {
 public:
  DenseIsland();

  /// Above this number of rows, making B and factoring the Newton matrix cost more than sweeps along the chains of the links.
  static constexpr int max_rows = 96;

  /// Solves the island, beginning with the impulses in `island.p`. If it does not converge, `island.p` holds the best impulses found.
  /// O(rows^2 depth) for B, O(active rows^3) for each Newton step.
  /// @param compliance s of contacts as a fraction of B[0], which includes s
  /// @param tolerance m/s
  DenseResult solve(const IslandRows& island, double compliance, double tolerance);

 private:
  /// Role of an unknown of the Newton step in the three rows of its contact; `plain` stands for a single row of any block.
  enum class Role : unsigned char { plain, sliding_normal, sliding_side };
  struct Unknown {
    int row;  // the row of its equation; sliding contacts: the normal row
    Role role;
    double t1, t2;    // sliding_normal: mu d; sliding_side: e
    double diagonal;  // added to the matrix: compliance, turning of friction with the slip, or regularization
    double rest;      // diagonal times the impulse about which the regularization is centred
  };

  void pack(const IslandRows& island);
  void make_matrix(const IslandRows& island);
  void update_velocities();
  double sweep(const IslandRows& island, double compliance, bool forward);
  void collect_unknowns(const IslandRows& island, double compliance);
  void add_contact(const RowBlock& b, int row, double compliance);
  void make_equations();
  bool newton_step(const IslandRows& island, double compliance);
  void project(const IslandRows& island);
  /// p_n + impact_impulse of the contact of a roll block. @param block its position in the island
  [[nodiscard]] double normal_impulse(std::size_t block) const {
    return p_[static_cast<std::size_t>(local_[block - 1])] + impact_impulse_[block];
  }
  [[nodiscard]] const double* column(int row) const {
    return B_.data() + static_cast<std::size_t>(row) * static_cast<std::size_t>(stride_);
  }

  int n_ = 0, stride_ = 0;              // rows; distance of two rows of B_
  std::vector<int> local_;              // [blocks of the island] first row in the island
  std::vector<double> impact_impulse_;  // [blocks of the island] N s: of the contact of a roll block
  std::vector<double> packed_;          // [entries][4] the rows of each segment side by side
  std::vector<int> packed_at_;          // [blocks of the island][2] first value of each segment in packed_
  std::vector<double> B_;               // [n][stride] symmetric
  std::vector<double> target_, p_, u_;  // [n]
  std::vector<double> best_p_;          // [n] impulses with the smallest change so far
  std::vector<double> fixed_;           // [n] the part of p that is not unknown
  std::vector<double> fixed_u_;         // [n] velocities with fixed_ alone
  std::vector<double> made_u_;          // [n] velocities that a unit of one unknown makes
  std::vector<Unknown> unknowns_;
  std::vector<double> A_, z_;  // [unknowns][unknowns + 1], the last column is the right side; [unknowns]
};

}  // namespace ugoki::contact
