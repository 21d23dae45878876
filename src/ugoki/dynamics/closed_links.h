#pragma once
// Closed link systems at a cost linear in the links: articulated bodies that carry the multipliers of the loops.
//
//   M vdot + b = tau + J^T lambda,   J vdot + dJ/dt v = 0            (paper, section 5, with multipliers)
//
// The recursion from the tips to the base keeps, beside the articulated inertia of each link, the columns P with which the
// multipliers of the loops that are open there act on it, and the condensed matrix Lambda of these multipliers. At the link
// where the two branches of a loop meet, its multipliers are eliminated (Cholesky with pivoting on its own block: rows that
// depend on others get no multiplier) and stiffen the articulated inertia. So a loop costs what its own links cost, however
// many loops there are beside it or in series; loops that meet at the world are eliminated in an order of least fill.
// Source: Popov, Vereshchagin, Zenkevich (1978); Featherstone (2008), ch. 8, 9; Sathya & Carpentier (2024) for the elimination
// on the way to the base.

#include <memory>
#include <span>
#include <vector>

#include "ugoki/dynamics/closed_structure.h"
#include "ugoki/dynamics/loop_rows.h"

namespace ugoki::dynamics {

/// Part of another link's inertia that a link without one of its own takes (virtual links).
struct InertiaShare {
  int link, source;
  double part;
};

/// A pivot below this part of the greatest of the loop's rows of its kind is rounding: the row follows from others. The condensed matrix
/// is quadratic in the Jacobian, so rows whose angle to the others is below 1e-6 rad count as dependent.
inline constexpr double dependent_row = 1e-12;
/// A row that the joints on its way move by less than this part (squared) of what they would if they stood at right angles to it and as far
/// away as the mechanism is large is moved by rounding alone: planar chains, and chains about a point. There may be nothing else to
/// compare it with.
inline constexpr double immobile_row = 1e-24;
/// The same for corrections, as part of the typical least pivot. Within an angle d of a singular position a gap of rounding eps would be
/// answered by a correction eps / d of the position, eps / d^2 of the velocity and eps / d^3 of the acceleration; below 1e-3 rad it is
/// better to wait.
inline constexpr double dependent_correction = 1e-6;

/// Structure and scratch for one mechanism with loops; caller-owned, one a thread.
class ClosedLinks {
 public:
  /// With the mechanism's own loops, those that are closed at the start.
  explicit ClosedLinks(const Mechanism& m);
  /// With these loops, of which those marked are closed. @param closed [loops]
  /// @param rows [rows of all loops] 0 for rows to leave out because they always follow from others; empty: none
  ClosedLinks(const Mechanism& m, std::vector<Loop> loops, std::span<const char> closed, std::span<const char> rows = {});

  ClosedLinks(ClosedLinks&&) noexcept;
  ClosedLinks& operator=(ClosedLinks&&) noexcept;
  ~ClosedLinks();

  [[nodiscard]] std::span<const Loop> loops() const { return loops_; }
  [[nodiscard]] bool is_closed(int loop) const { return over_links_.entry_of_loop[static_cast<std::size_t>(loop)] >= 0; }
  [[nodiscard]] const LoopRows& rows() const { return rows_; }
  /// Multipliers of the last solve: N | N m (forces) or N s | N m s (impulses), zero for open loops. [rows().count()]
  [[nodiscard]] std::span<const double> multipliers() const { return multipliers_; }
  /// Independent rows found by the last factorization.
  [[nodiscard]] int rank() const { return rank_; }
  /// True where the last factorization was within about 3e-3 rad of a singular position (a dead point, a change point), or in it: its least
  /// pivot is below 1e-5 of the greatest that this had so far, or its rank is.
  [[nodiscard]] bool is_nearly_singular() const { return rank_ < full_rank_ || weakest_ < 1e-5 * typical_; }
  /// The least pivot of an independent row in the last factorization, as part of the greatest of its kind. 1 without loops.
  [[nodiscard]] double weakest() const { return weakest_; }
  /// The greatest least pivot of a factorization so far, as part of the greatest of its kind: small also where masses are very unequal.
  [[nodiscard]] double typical() const { return typical_; }
  /// What is_nearly_singular() compares with, from factorizations so far: the only memory, for saving and restoring a simulation.
  struct Memory {
    double typical = 0;
    int full_rank = 0;
  };
  [[nodiscard]] Memory memory() const { return {typical_, full_rank_}; }
  void set_memory(const Memory& memory) {
    typical_ = memory.typical;
    full_rank_ = memory.full_rank;
  }
  /// The freedom at which the last factorization found no inertia, or -1.
  [[nodiscard]] int singular_freedom() const { return singular_freedom_; }
  /// For each row of rows(): 1 if it took part in the last factorization as an independent one. [rows().count()]
  [[nodiscard]] std::span<const char> independent() const { return independent_; }

 private:
  friend class ClosedSolver;
  friend class ClosedRun;
  friend void share_virtual_inertias(const ClosedLinks& closed, Workspace& ws);
  friend struct ClosedKernelState;

  void share_inertias(const Mechanism& m);

  std::vector<Loop> loops_;
  LoopRows rows_;
  ClosedStructure over_links_;
  std::vector<InertiaShare> shares_;

  std::vector<Inertia> I_;              ///< [links] with the shares
  std::vector<Vec6> P_;                 ///< [present_rows]
  std::vector<double> s_;               ///< [s_rows]
  std::vector<double> Lambda_;          ///< [blocks * 36] row by row, as wide as the second entry
  std::vector<double> C_;               ///< [entries * 36] factor of the own block
  std::vector<double> Y_;               ///< [neighbours * 36]
  std::vector<int> rank_of_;            ///< [entries]
  std::vector<int> pivots_;             ///< [multipliers] rows of a block in the order of their pivots
  std::vector<Vec6> Z_;                 ///< [multipliers]
  std::vector<double> reduced_;         ///< [multipliers] what eliminations took from the diagonal
  std::vector<double> terms_;           ///< [multipliers] the diagonal if all directions agreed: what rounding is measured by
  double length_ = 1;                   ///< m: of the mechanism's parts
  std::vector<double> g_, z_, lambda_;  ///< [multipliers]
  std::vector<double> multipliers_;
  std::vector<char> independent_;
  std::vector<double> delta_;  ///< [nv] corrections of the projections
  int rank_ = 0;
  int singular_freedom_ = -1;
  double weakest_ = 1;  ///< least pivot of an independent row, as part of the greatest of its kind
  int full_rank_ = 0;   ///< greatest rank met
  double typical_ = 0;  ///< greatest weakest_ met with it
  void note_rank();

  std::unique_ptr<struct ClosedKernelState> kernel_;  ///< of the functions that start from q and v
};

/// What a solve came to.
enum class ClosedStatus : unsigned char {
  ok,
  singular_inertia,  ///< a joint moves nothing that has inertia
  not_closed,        ///< the gap did not come down to rounding
};

/// Accelerations of the closed system from the state alone, and with them the forces in the loops (the multipliers): the fastest, in
/// link frames, with the registers that the processor has. O(links) for loops of bounded size. Allocates nothing.
/// @param external [links] or empty @param vdot [nv, out] must not alias an input
[[nodiscard]] ClosedStatus calc_closed_forward_dynamics(const Mechanism& m, ClosedLinks& closed, std::span<const double> q,
                                                        std::span<const double> v, std::span<const double> tau, const Vec3& gravity,
                                                        std::span<const Vec6> external, std::span<double> vdot);

// In stages, on what update_kinematics() leaves in a workspace: for many solves at one position.

/// Rows, articulated inertias and the condensed matrix of the closed loops, at what update_kinematics(q, v) left in `ws`.
/// Uses ws.IA, U, d. O(links) for loops of bounded size. Allocates nothing.
/// @param dependent part of the greatest pivot below which a row is left out; the square of an angle
[[nodiscard]] ClosedStatus factor_closed_links(const Mechanism& m, Workspace& ws, ClosedLinks& closed, std::span<const double> q,
                                               std::span<const double> v, double dependent = dependent_row);

/// Forward dynamics after factor_closed_links(). @param tau, external as in dynamics.h @param vdot [nv, out]
/// The multipliers are the forces in the loops.
void calc_closed_forward_dynamics(const Mechanism& m, Workspace& ws, ClosedLinks& closed, std::span<const double> tau, const Vec3& gravity,
                                  std::span<const Vec6> external, std::span<double> vdot);

/// v <- v - M^-1 J^T (J M^-1 J^T)^-1 J v after factor_closed_links(): the velocity nearest to v, in kinetic energy, that opens no
/// loop. It is what a sudden closing of the loops leaves of v; the multipliers are the impulses.
void project_velocity(const Mechanism& m, Workspace& ws, ClosedLinks& closed, std::span<double> v);

/// M x = r + J^T lambda, J (v + x) = 0 after factor_closed_links(): one solve, as exact as the recursion is (closed_impulse.h refines it).
/// @param r, v, x [nv]; x must alias neither. The multipliers are lambda.
void solve_closed_links(const Mechanism& m, Workspace& ws, ClosedLinks& closed, std::span<const double> r, std::span<const double> v,
                        std::span<double> x);

/// Moves q until the gaps are at rounding: Newton steps of least kinetic energy; near a singular position, where the gaps allow it,
/// without the directions that are singular there (dependent_correction). Calls update_kinematics() with `v` and
/// factors; leaves both at the final q.
/// @param gap [out] greatest remaining gap, m | rad. @param limit of Newton steps
[[nodiscard]] ClosedStatus project_position(const Mechanism& m, Workspace& ws, ClosedLinks& closed, std::span<double> q,
                                            std::span<const double> v, double& gap, int limit = 20);

/// ws.I of virtual links without inertia of their own becomes their share of the real link's (docs/design/closed-links.md), as
/// factor_closed_links() has it. After update_kinematics(), for methods that go over the tree themselves.
void share_virtual_inertias(const ClosedLinks& closed, Workspace& ws);

/// Greatest gap of the closed loops' independent rows, as the last factorization and update of the rows saw them, m | rad. (Rows that
/// follow from others keep a gap of their own where the frames of a file do not quite agree.)
[[nodiscard]] double greatest_gap(const ClosedLinks& closed);

}  // namespace ugoki::dynamics
