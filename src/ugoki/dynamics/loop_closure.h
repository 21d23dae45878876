#pragma once
// Closing of loops at position and velocity level: the gaps of all closed loops are reduced to rounding error.
//
// There are two methods. Near a closed configuration, Newton's method solves for theta_S while theta_G stays fixed (coordinate
// partitioning; Wehage & Haug 1982, J. Mech. Design 104, 247). From any configuration, the damped least-squares method of
// Levenberg and Marquardt moves all DOFs as little as possible. It needs no rank decision and tolerates redundant and contradictory
// rows.

#include "ugoki/dynamics/loop_partition.h"

namespace ugoki::dynamics {

/// Result of closing the loops.
struct Closure {
  bool closed = false;  ///< true: the maximum gap is only rounding error
  int iterations = 0;
  double gap = 0;  ///< remaining absolute gap of `row`: m | rad | 1 (cosine of an angle)
  int row = -1;    ///< row with the maximum scaled gap, index into ClosedWorkspace::rows; -1: no loop is closed
};

/// Moves theta_S by Newton's method until the independent rows have no gap; theta_G stays fixed. No allocation.
/// @param q [nq, in/out] m | rad
[[nodiscard]] Closure close_theta_S(const Mechanism& m, std::span<double> q, ClosedWorkspace& cw);

/// Moves all DOFs to a nearby closed configuration by damped least squares. O(iterations rows^3).
/// @param q [nq, in/out] m | rad; afterwards the configuration with the smallest gap that was found
/// @param weights [nv] cost of moving each DOF, with distances in units of cw.length; infinite: the DOF stays fixed. Empty: all 1
[[nodiscard]] Closure close_positions(const Mechanism& m, std::span<double> q, ClosedWorkspace& cw, std::span<const double> weights = {});

/// Closes the loops as close_positions() does, also from a distant configuration: if the given start fails, or closes a loop with its two
/// axes antiparallel, the function tries starts that are perturbed (the same perturbations in every run). Allocates.
[[nodiscard]] Closure assemble(const Mechanism& m, std::span<double> q, ClosedWorkspace& cw, std::span<const double> weights = {});

/// Replaces v by the nearest velocity with J v = 0, at a closed q. @param weights as in close_positions()
/// @param v [nv, in/out] m/s | rad/s
void close_velocities(const Mechanism& m, std::span<const double> q, std::span<double> v, ClosedWorkspace& cw,
                      std::span<const double> weights = {});

/// Rank of J in general position: the maximum rank found near a closed q, in a few pseudo-random steps along the degrees of freedom.
/// Sets cw.full_rank, cw.full_pivot_ratio and cw.contradiction. Allocates.
/// @param general [nq, out] a configuration at which J has this rank; may alias `q`; empty: not returned
int find_full_rank(const Mechanism& m, std::span<const double> q, ClosedWorkspace& cw, std::span<double> general = {});

/// Computes kinematics and loop rows at q with zero velocity, into cw.open and cw.rows.
void update_gaps(const Mechanism& m, std::span<const double> q, ClosedWorkspace& cw);

/// Maximum gap of the closed loops, from the rows that update_loop_rows() computed last.
[[nodiscard]] Closure measure_gap(const ClosedWorkspace& cw);

}  // namespace ugoki::dynamics
