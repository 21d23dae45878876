#pragma once
// Impulses of all contacts, limits and dry frictions of a step, at the level of velocities.
//
// Rows come whitened: with M' = L^T D L of a system, y = D^-1/2 L^-T J^T and w = D^1/2 L (v - v_free), so that
//   J v = target + y . w,   w = sum of y p,   |w|^2 / 2 = the kinetic energy of what the impulses add,
// and the systems' masses need not be known here. The impulses p solve, with B = Y Y^T,
//   contact (n, t1, t2):  u_n + s p_n >= 0,  p_n >= 0,  one of them zero;   |p_t| <= mu (p_n + struck), against the sliding u_t
//   limit:                u >= 0, p >= 0, one of them zero
//   friction:             |p| <= bound, against u
//   roll (3 rows):        |p| <= bound (p_n + struck) of its contact, against u
// island by island (systems that are joined by rows). Every island is swept: contact after contact, each solved with its own
// 3 x 3 matrix. Where sweeps are slow (heavy on light, towers) the island is finished by Newton's method on w for the augmented
// Lagrangian, whose sparse matrix 1 + Y^T G Y couples only systems that touch (envelope Cholesky, breadth-first order).
// Sources: Moreau (1988), Unilateral contact and dry friction in finite freedom dynamics; Hwangbo, Lee, Hutter (2018), Per-contact
// iteration method; Alart, Curnier (1991), A mixed formulation for frictional contact problems prone to Newton-like methods.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace ugoki::contact {

enum class RowKind : unsigned char { contact, limit, friction, roll };

/// Rows of a block on one system: `rows` vectors of `length` entries from `offset` on.
struct RowSegment {
  int system;
  int first;         ///< where the system's freedoms begin in w
  const int* index;  ///< [length] freedoms of the chain; null: 0 ... length - 1
  int length;
  int offset;
};

/// Rows that are solved together.
struct RowBlock {
  RowKind kind;
  int rows;           ///< 3 for contact and roll, 1 for the others
  int row;            ///< first entry in target and impulse
  int first_segment;  ///< one or two
  int segments;       //
  int contact;        ///< index into the step's contacts; -1: none
  int leader;         ///< roll: block of its contact
  double mu;          ///< Coulomb coefficient; roll: lever of rolling resistance [m]
  double bound;       ///< N s | N m s (friction)
  double struck;      ///< N s: normal impulse that the impact has already given (contact)
  std::uint64_t key;  ///< the same from step to step
  double B[6];        ///< Y Y^T: 00 11 22 01 02 12
  double inverse[6];  ///< its inverse (contact)
  double size;        ///< root of the greatest of B's diagonal
  double lever;       ///< m: radius of what rolls, which makes its velocities those of its surface; 1 for the others
  double seen;        ///< what its systems had moved when it was solved last
  double change;      ///< m/s: of its velocity in the last sweep
};

struct SolverOptions {
  int iterations = 60;      ///< greatest number of sweeps over an island
  double tolerance = 1e-7;  ///< m/s: an island is done when a sweep changes no velocity more
  double coarse = 0.05;     ///< m/s: the same in a crowd; a fifth of it where Newton's method would cost too much
  double softness = 1e-4;   ///< s as part of a contact's own inverse inertia: redundant contacts share their load
};

struct SolverReport {
  int islands = 0;       ///< that have rows
  int sweeps = 0;        ///< of the island that took most
  int newton_steps = 0;  ///< of all islands
  double residual = 0;   ///< m/s: greatest change of a velocity in the last sweep
};

class VelocitySolver {
 public:
  /// @param first [systems + 1] where each system's freedoms begin in w
  void set_systems(std::span<const int> first);

  /// Removes all rows.
  void clear();

  // Building: begin_block, add_segment once or twice and fill its rows, then end_block or drop_block.
  RowBlock& begin_block(RowKind kind, std::uint64_t key);
  /// @return [rows * length] to be filled with whitened rows. Valid until the next call
  std::span<double> add_segment(int system, const int* index, int length);
  /// The rows of the last segment.
  [[nodiscard]] std::span<double> last_segment() { return std::span(rows_).subspan(static_cast<std::size_t>(segments_.back().offset)); }
  /// @param target [rows] velocity without impulses, less what is wanted
  void end_block(std::span<const double> target, std::span<const double> warm);
  void drop_block();

  SolverReport solve(const SolverOptions& options);
  /// After solve(), when blocks were added: only islands that have one of them, from the impulses that are there.
  /// @param first_new block
  SolverReport solve_again(const SolverOptions& options, std::size_t first_new);
  /// Whether the last solve may have changed w of a system.
  [[nodiscard]] bool is_solved(int system) const { return solved_[static_cast<std::size_t>(system)] != 0; }

  [[nodiscard]] std::span<const RowBlock> blocks() const { return blocks_; }
  [[nodiscard]] std::span<const double> impulses() const { return p_; }
  [[nodiscard]] std::span<const double> impulses(const RowBlock& b) const {
    return std::span(p_).subspan(static_cast<std::size_t>(b.row), static_cast<std::size_t>(b.rows));
  }
  /// w of one system, after solve().
  [[nodiscard]] std::span<const double> w(int system) const {
    const auto s = static_cast<std::size_t>(system);
    return std::span(w_).subspan(static_cast<std::size_t>(first_[s]), static_cast<std::size_t>(first_[s + 1] - first_[s]));
  }

 private:
  struct Island {
    int first_block, blocks;    // in order_
    int first_system, systems;  // in members_
  };

  void velocities(const RowBlock& b, double* u) const;
  void apply(const RowBlock& b, const double* p);
  double relax(RowBlock& b);
  [[nodiscard]] double& moved_of(const RowBlock& b, int segment) {
    return moved_[static_cast<std::size_t>(segments_[static_cast<std::size_t>(b.first_segment + segment)].system)];
  }
  double sweep(const Island& island, bool forward, double least);
  void begin_blocks(const SolverOptions& options, std::size_t first);
  void find_islands();
  void solve_island(const Island& island, const SolverOptions& options, SolverReport& report);

  // Newton's method, in velocity_newton.cpp
  int newton_on_part(const Island& island, double tolerance);
  bool order_systems(const Island& island, int steps);
  [[nodiscard]] int place(const RowSegment& x, int e) const;
  int newton(const Island& island, bool part, double change, double tolerance);
  void fix_law(const Island& island);
  int minimise(const Island& island);
  void solve_newton();
  double assemble(const Island& island);
  void assemble_matrix(const Island& island);
  void add_to_matrix(const RowBlock& b, const double* G);
  double impulse_of(const RowBlock& b, const double* u, double* p, double* G) const;
  void recompute_w(const Island& island);

  std::vector<int> first_;  // [systems + 1]
  std::vector<RowBlock> blocks_;
  std::vector<RowSegment> segments_;
  std::vector<double> rows_;
  std::vector<double> target_, p_;
  std::vector<double> w_;
  std::vector<double> moved_;  // [systems] how far sweeps have changed w at most, summed up
  double softness_ = 0;        // part of B[0] of contacts

  // Islands
  std::vector<int> root_;     // [systems] union-find
  std::vector<int> island_;   // [systems]
  std::vector<int> order_;    // blocks by island
  std::vector<int> members_;  // systems by island
  std::vector<int> cursor_;
  std::vector<Island> islands_;
  std::vector<char> solved_;  // [systems]

  // Newton
  double part_ = 0;                 // R as part of a block's inverse inertia
  double budget_ = 0, cost_ = 0;    // operations: left in this step, of one Newton step
  std::vector<int> local_;          // [systems] first row in the matrix
  std::vector<int> lowest_;         // [n] first column of a row in the envelope
  std::vector<std::size_t> start_;  // [n] where column 0 of the row would be in H_ (shifted by lowest_)
  std::vector<double> H_;           // envelope, row by row
  std::vector<double> G_;           // [blocks of the island * 9] -dp/du, row by row
  std::vector<double> F_, step_, old_w_, old_p_, hat_, lag_;
  std::vector<double> base_;  // as w: what other blocks' impulses are of it
  std::vector<double> scratch_w_;
  std::vector<char> in_part_;  // [systems]
  std::vector<int> neighbour_first_, neighbours_, queue_;
};

}  // namespace ugoki::contact
