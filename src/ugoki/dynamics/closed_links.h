#pragma once
// Forward dynamics of closed link systems at a cost linear in the number of links: the articulated-body recursion extended by the
// multipliers lambda of the loops.
//
//   M vdot + b = tau + J^T lambda,   J vdot + dJ/dt v = 0            (Nagashima 1999, section 5, with multipliers)
//
// The recursion from the tips to the base computes three quantities. The first is the articulated inertia of each link. The second are the
// columns P: the wrenches that unit multipliers of the loops not yet eliminated exert on the link. The third is the condensed matrix of
// these multipliers, Lambda = J M^-1 J^T. A loop is eliminated at the link where its two branches meet, by a pivoted Cholesky factorization
// of its own block of Lambda. Rows that depend linearly on other rows get no multiplier. The elimination adds the loop's stiffness to the
// articulated inertia. A loop therefore costs as much as its own links, independent of the number of other loops. Loops that meet at the
// same link, or at the world, are eliminated in minimum-degree order.
//
// Sources: Popov, Vereshchagin, Zenkevich (1978); Featherstone (2008), ch. 8, 9; Sathya & Carpentier (2024) for the elimination during the
// sweep to the base.

#include <memory>
#include <span>
#include <vector>

#include "ugoki/dynamics/closed_structure.h"
#include "ugoki/dynamics/loop_rows.h"

namespace ugoki::dynamics {

/// One share of a divided inertia: `link` gets the fraction `part` of the inertia of the real link `source`. A virtual link is a second
/// body of a real link, made where a loop was cut. The real link and its virtual links without inertia of their own get equal shares, so
/// that every joint of the cut tree moves some inertia. The closed system stays the same. The real link's own share has link = source.
struct InertiaShare {
  int link, source;
  double part;  ///< fraction of the source's inertia, 0 to 1
};

/// Pivot threshold below which a row of a loop counts as dependent on the other rows. It is a fraction of the largest diagonal entry of
/// Lambda among the loop's rows of the same kind (position rows or rotation rows). Lambda = J M^-1 J^T is quadratic in J, so the threshold
/// corresponds to an angle of 1e-6 rad between the row and the space of the other rows.
inline constexpr double dependent_row = 1e-12;
/// Threshold for immobile rows: rows that no joint of the loop moves. Examples: the out-of-plane rows of planar chains, the position rows
/// of chains whose axes meet in one point. Such a row's diagonal entry of Lambda is only rounding error. A row counts as immobile if this
/// entry is below this fraction of its upper bound. The bound is the value that the entry would have if every joint on the loop's path
/// moved the row at right angles, at the mechanism's characteristic length. 1e-24 in Lambda is 1e-12 in J. The loop's other rows cannot
/// serve as the scale, because all of them may be immobile. Tests: rings_test.cpp.
inline constexpr double immobile_row = 1e-24;
/// Pivot threshold of position corrections, as a fraction of typical_pivot_ratio(). At an angle d from a singular position a gap of size
/// eps (rounding) causes a correction of eps / d in position, eps / d^2 in velocity and eps / d^3 in acceleration. The value is the square
/// of d = 1e-3 rad. Directions with pivots below the threshold are corrected only if the gap cannot be closed without them.
inline constexpr double dependent_correction = 1e-6;

/// The loops of one mechanism, the structure of their elimination, and scratch memory. Owned by the caller; use one per thread.
class ClosedLinks {
 public:
  /// Uses the mechanism's own loops; those with Loop::closed set are closed.
  explicit ClosedLinks(const Mechanism& m);
  /// Uses the given loops. @param closed [loops] 1 if the loop is closed
  /// @param rows [rows of all loops] 0 for rows to leave out because they depend on others at every position; empty: use all rows
  ClosedLinks(const Mechanism& m, std::vector<Loop> loops, std::span<const char> closed, std::span<const char> rows = {});

  ClosedLinks(ClosedLinks&&) noexcept;
  ClosedLinks& operator=(ClosedLinks&&) noexcept;
  ~ClosedLinks();

  [[nodiscard]] std::span<const Loop> loops() const { return loops_; }
  [[nodiscard]] bool is_closed(int loop) const { return over_links_.entry_of_loop[static_cast<std::size_t>(loop)] >= 0; }
  [[nodiscard]] const LoopRows& rows() const { return rows_; }
  /// [rows().count()] multipliers of the last solve: N | N m after forward dynamics, N s | N m s after an impulse. Zero for open loops.
  [[nodiscard]] std::span<const double> multipliers() const { return multipliers_; }
  /// Number of independent rows in the last factorization.
  [[nodiscard]] int rank() const { return rank_; }
  /// True if the last factorization was at a singular position (dead point or change point) or within about 3e-3 rad of one. Criterion: the
  /// rank is below the maximum rank so far, or min_pivot_ratio() is below 1e-5 typical_pivot_ratio(). 1e-5 is the square of 3e-3 rad.
  [[nodiscard]] bool is_nearly_singular() const { return rank_ < full_rank_ || min_pivot_ratio_ < 1e-5 * typical_pivot_ratio_; }
  /// Smallest pivot of an independent row in the last factorization, as a fraction of the largest diagonal entry of the loop's rows of the
  /// same kind (position or rotation). 1 if no loop is closed.
  [[nodiscard]] double min_pivot_ratio() const { return min_pivot_ratio_; }
  /// Maximum of min_pivot_ratio() over all factorizations of maximum rank so far. Very unequal masses also make it small.
  [[nodiscard]] double typical_pivot_ratio() const { return typical_pivot_ratio_; }
  /// The reference values of is_nearly_singular(). They are the only state that depends on earlier calls; save them with a simulation.
  struct Memory {
    double typical_pivot_ratio = 0;
    int full_rank = 0;
  };
  [[nodiscard]] Memory memory() const { return {typical_pivot_ratio_, full_rank_}; }
  void set_memory(const Memory& memory) {
    typical_pivot_ratio_ = memory.typical_pivot_ratio;
    full_rank_ = memory.full_rank;
  }
  /// Velocity index of the DOF for which the last factorization found no inertia, or -1.
  [[nodiscard]] int singular_dof() const { return singular_dof_; }
  /// For each row of rows(): 1 if it was an independent row of a closed loop in the last factorization. [rows().count()]
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

  std::vector<Inertia> I_;              ///< [links] inertias after the division that InertiaShare describes
  std::vector<Vec6> P_;                 ///< [present_rows] columns P, see the top
  std::vector<double> s_;               ///< [s_rows] S . P, S: joint axis of a DOF
  std::vector<double> Lambda_;          ///< [blocks * 36] blocks of Lambda, row-major; row length: rows of the second loop
  std::vector<double> C_;               ///< [entries * 36] Cholesky factor of the loop's diagonal block
  std::vector<double> Y_;               ///< [neighbours * 36] C^-1 Lambda(eliminated loop, neighbour)
  std::vector<int> rank_of_;            ///< [entries] number of independent rows of each closed loop
  std::vector<int> pivots_;             ///< [multipliers] for each loop, its row indices in pivot order
  std::vector<Vec6> Z_;                 ///< [multipliers] C^-1 P^T
  std::vector<double> reduced_;         ///< [multipliers] amount that eliminations subtracted from the diagonal of Lambda
  std::vector<double> terms_;           ///< [multipliers] upper bound of the diagonal of Lambda; scale of immobile_row
  double length_ = 1;                   ///< m: characteristic length of the mechanism
  std::vector<double> g_, z_, lambda_;  ///< [multipliers] residuals, C^-1 g, multipliers
  std::vector<double> multipliers_;     ///< [rows of all loops] see multipliers()
  std::vector<char> independent_;       ///< [rows of all loops] see independent()
  std::vector<double> delta_;           ///< [nv] change of v or q that a projection computes
  int rank_ = 0;
  int singular_dof_ = -1;
  double min_pivot_ratio_ = 1;
  int full_rank_ = 0;               ///< maximum rank so far
  double typical_pivot_ratio_ = 0;  ///< maximum of min_pivot_ratio_ over factorizations of rank full_rank_
  void note_rank();

  std::unique_ptr<struct ClosedKernelState> kernel_;  ///< used by calc_closed_forward_dynamics() from q and v
};

/// Result of a solve.
enum class ClosedStatus : unsigned char {
  ok,
  singular_inertia,  ///< a DOF moves no inertia
  not_closed,        ///< the gap could not be reduced to rounding
};

/// Accelerations of the closed system from q and v, and the forces in the loops (multipliers()). The fastest function for them: computes in
/// link frames and uses the widest SIMD registers. O(links) for loops of bounded size. Allocates nothing.
/// @param tau [nv] N | N m @param gravity m/s^2, world @param external [links] wrenches as in dynamics.h, or empty
/// @param vdot [nv, out] must not alias an input
[[nodiscard]] ClosedStatus calc_closed_forward_dynamics(const Mechanism& m, ClosedLinks& closed, std::span<const double> q,
                                                        std::span<const double> v, std::span<const double> tau, const Vec3& gravity,
                                                        std::span<const Vec6> external, std::span<double> vdot);

// Staged functions for several solves at one position. They use the results of update_kinematics() in `ws`.

/// Computes the rows, the articulated inertias and the factored condensed matrix of the closed loops. Call update_kinematics(q, v) first.
/// Overwrites ws.IA, ws.U, ws.d. O(links) for loops of bounded size. Allocates nothing.
/// @param dependent pivot threshold for dependent rows, see dependent_row
[[nodiscard]] ClosedStatus factor_closed_links(const Mechanism& m, Workspace& ws, ClosedLinks& closed, std::span<const double> q,
                                               std::span<const double> v, double dependent = dependent_row);

/// Forward dynamics; call factor_closed_links() first. multipliers() returns the forces in the loops afterwards.
/// @param tau, external as in dynamics.h @param vdot [nv, out]
void calc_closed_forward_dynamics(const Mechanism& m, Workspace& ws, ClosedLinks& closed, std::span<const double> tau, const Vec3& gravity,
                                  std::span<const Vec6> external, std::span<double> vdot);

/// Projects v onto velocities that open no loop: v <- v - M^-1 J^T (J M^-1 J^T)^-1 J v, after factor_closed_links().
/// The result is the closest such velocity in the kinetic-energy norm. It is also the velocity after the loops close suddenly;
/// multipliers() then returns the impulses of the closing.
void project_velocity(const Mechanism& m, Workspace& ws, ClosedLinks& closed, std::span<double> v);

/// Solves M x = r + J^T lambda, J (v + x) = 0 after factor_closed_links(). The accuracy is that of one recursion; ClosedImpulse::solve()
/// refines the result. multipliers() returns lambda afterwards. @param r, v, x [nv]; x must not alias r or v
void solve_closed_links(const Mechanism& m, Workspace& ws, ClosedLinks& closed, std::span<const double> r, std::span<const double> v,
                        std::span<double> x);

/// Closes the loops in position: changes q by Newton steps of minimum kinetic energy until the gaps are at rounding. Near a singular
/// position, nearly singular directions are left uncorrected if the gaps can be closed without them (dependent_correction). Calls
/// update_kinematics() with `v` and factor_closed_links(); both are valid for the final q on return.
/// @param gap [out] maximum remaining gap, m | rad @param limit maximum number of Newton steps
[[nodiscard]] ClosedStatus project_position(const Mechanism& m, Workspace& ws, ClosedLinks& closed, std::span<double> q,
                                            std::span<const double> v, double& gap, int limit = 20);

/// project_position() for callers that need only q. Kinematics and factor are usually those of the position before the last Newton step.
[[nodiscard]] ClosedStatus close_position(const Mechanism& m, Workspace& ws, ClosedLinks& closed, std::span<double> q,
                                          std::span<const double> v, double& gap, int limit = 20);

/// Divides the inertia of each real link in ws.I equally among the link and its massless virtual links (see InertiaShare and
/// docs/design/closed-links.md). factor_closed_links() uses the same shares internally. Methods that run their own recursion over the tree
/// call this function after update_kinematics().
void share_virtual_inertias(const ClosedLinks& closed, Workspace& ws);

/// Maximum gap of the independent rows of the closed loops at the last factorization, m | rad. Dependent rows are not counted: they keep a
/// residual gap if the frames in the model file are not exactly consistent.
[[nodiscard]] double max_gap(const ClosedLinks& closed);

}  // namespace ugoki::dynamics
