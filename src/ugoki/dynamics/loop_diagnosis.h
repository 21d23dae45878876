#pragma once
// What the loops of a mechanism do to it, for people: degrees of freedom, redundant rows, singular positions, why loops do not close.

#include <string>

#include "ugoki/base/result.h"
#include "ugoki/dynamics/loop_closure.h"

namespace ugoki::dynamics {

/// Rows are indices into ClosedWorkspace::rows.
struct LoopDiagnosis {
  int rows = 0;       ///< of the closed loops
  int rank = 0;       ///< independent ones in general position
  int rank_here = 0;  ///< at the configuration given
  int freedoms = 0;   ///< degrees of freedom in general position
  int freedoms_here = 0;
  std::vector<int> redundant;  ///< rows that always follow from others: the system is over-constrained
  std::vector<int> vanishing;  ///< rows that count in general but not here: a dead point or change point
  double pivot_part = 1;       ///< weakest independent row over the strongest

  [[nodiscard]] bool is_singular_here() const { return rank_here < rank; }
};

/// @param q [nq] closed. Allocates; cw.full_rank is known afterwards.
[[nodiscard]] LoopDiagnosis diagnose_loops(const Mechanism& m, std::span<const double> q, ClosedWorkspace& cw);

/// "1 degree of freedom: ..." with the rows by loop and name.
[[nodiscard]] std::string describe(const LoopDiagnosis& diagnosis, const ClosedWorkspace& cw);

/// Why a loop does not close, in words: the loop, the row, what is left of the gap, and how long its links are.
[[nodiscard]] Error explain_gap(const Mechanism& m, const ClosedWorkspace& cw, const Closure& closure);

}  // namespace ugoki::dynamics
