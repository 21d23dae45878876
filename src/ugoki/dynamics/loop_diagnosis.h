#pragma once
// Diagnosis of the loops of a mechanism, as data and as text for the user: degrees of freedom, redundant rows, singular
// configurations, and the reason why a loop cannot be closed.

#include <string>

#include "ugoki/base/result.h"
#include "ugoki/dynamics/loop_closure.h"

namespace ugoki::dynamics {

/// "General position" means almost every configuration near the given one; "here" means exactly the given configuration.
struct LoopDiagnosis {
  int rows = 0;       ///< number of rows of the closed loops
  int rank = 0;       ///< number of independent rows in general position
  int rank_here = 0;  ///< number of independent rows at the given configuration
  int dofs = 0;       ///< degrees of freedom in general position
  int dofs_here = 0;  ///< degrees of freedom at the given configuration
  std::vector<int>
      redundant;  ///< rows that depend on other rows everywhere: the system is over-constrained; indices into ClosedWorkspace::rows
  std::vector<int> vanishing;  ///< rows that are dependent only here, at a dead point or change point; indices into ClosedWorkspace::rows
  double pivot_ratio = 1;      ///< smallest pivot of the independent rows divided by the largest, in general position

  [[nodiscard]] bool is_singular_here() const { return rank_here < rank; }
};

/// Finds the degrees of freedom, the redundant rows, and the rows that are dependent only at q. Allocates. Sets cw.full_rank.
/// @param q [nq] a configuration whose loops are closed
[[nodiscard]] LoopDiagnosis diagnose_loops(const Mechanism& m, std::span<const double> q, ClosedWorkspace& cw);

/// The diagnosis in English sentences: "1 degree of freedom: ...". The text names each row by its loop and direction.
[[nodiscard]] std::string describe(const LoopDiagnosis& diagnosis, const ClosedWorkspace& cw);

/// Error that explains why a loop cannot be closed: loop, row, remaining gap and, except for gears, the lengths of its links.
/// @param closure with closure.row >= 0
[[nodiscard]] Error explain_gap(const Mechanism& m, const ClosedWorkspace& cw, const Closure& closure);

}  // namespace ugoki::dynamics
