#pragma once
// Position and velocity level of closed link systems: bringing the gaps of all closed loops to rounding.
//
// Two ways. From near, and with theta_G held: Newton's method for theta_S (coordinate partitioning; Wehage & Haug 1982, J. Mech.
// Design 104, 247). From anywhere, moving all freedoms as little as possible: the damped least-squares method of Levenberg and
// Marquardt, which needs no rank and stands redundant and contradictory rows.

#include "ugoki/dynamics/loop_partition.h"

namespace ugoki::dynamics {

/// How far the loops are closed.
struct Closure {
  bool closed = false;  ///< the greatest gap is that of rounding
  int iterations = 0;
  double gap = 0;  ///< greatest gap that remains: m | rad | cosine
  int row = -1;    ///< where: index into ClosedWorkspace::rows; -1: no loop is closed
};

/// Moves theta_S until the independent rows close; theta_G stays. No allocation. @param q [nq, in/out]
[[nodiscard]] Closure close_theta_S(const Mechanism& m, std::span<double> q, ClosedWorkspace& cw);

/// Moves all freedoms, each as its weight allows, to the nearest closed configuration. O(iterations rows^3).
/// @param q [nq, in/out] left at the smallest gap that was found
/// @param weights [nv] cost of moving each freedom; infinite: held. Empty: all 1. (Distances are measured in cw.length.)
[[nodiscard]] Closure close_positions(const Mechanism& m, std::span<double> q, ClosedWorkspace& cw, std::span<const double> weights = {});

/// The same from far: other starts are tried where the first does not lead to closed loops with axes the right way round.
/// The starts are the same each time.
[[nodiscard]] Closure assemble(const Mechanism& m, std::span<double> q, ClosedWorkspace& cw, std::span<const double> weights = {});

/// v <- the nearest velocity with J v = 0, at a closed q. Weights as in close_positions.
void close_velocities(const Mechanism& m, std::span<const double> q, std::span<double> v, ClosedWorkspace& cw,
                      std::span<const double> weights = {});

/// Rank of J in general position near a closed q: the greatest met in a few steps along the freedoms. Sets cw.full_rank and
/// cw.full_pivot_part.
/// @param general [nq, out] where that rank was met; may be `q` itself, or empty
int find_full_rank(const Mechanism& m, std::span<const double> q, ClosedWorkspace& cw, std::span<double> general = {});

/// Kinematics at rest and gaps at q.
void update_gaps(const Mechanism& m, std::span<const double> q, ClosedWorkspace& cw);

/// Greatest gap of the closed loops at what update_loop_rows() left.
[[nodiscard]] Closure measure_gap(const ClosedWorkspace& cw);

}  // namespace ugoki::dynamics
