#pragma once
// Velocity jump x of a closed link system under an impulse r, accurate to rounding even with nearly singular loops or very unequal masses:
//
//   M x = r + J^T lambda,   J x = 0
//
// M is the inertia matrix, J the constraint matrix of the loops, lambda their multipliers. The recursion of closed_links.h adds the loops'
// stiffness to the articulated inertias. Near a singular position this addition loses digits of the momentum balance. Iterative refinement
// recovers them: it computes the residuals of both equations link by link, solves for the correction and adds it to x. Last, each tree that
// no loop connects to the world or to another tree is corrected as one rigid body, by the DOFs of its root. This rigid-body correction
// opens no loop and removes the remaining momentum error.
// Source: Higham (2002), Accuracy and stability of numerical algorithms, ch. 12 (fixed precision iterative refinement).

#include <span>
#include <vector>

#include "ugoki/dynamics/closed_links.h"

namespace ugoki::dynamics {

/// Solver for impulses on one mechanism with loops, with its scratch memory. Use one per thread.
class ClosedImpulse {
 public:
  /// Computes the velocity jump x caused by an impulse. Call factor_closed_links() and share_virtual_inertias() first.
  /// O(links). Allocates only in the first call for a given nv.
  /// @param r [nv] impulse on the DOFs, N s | N m s @param x [nv, out] velocity jump, m/s | rad/s; must not alias r
  void solve(const Mechanism& m, Workspace& ws, ClosedLinks& closed, std::span<const double> r, std::span<double> x);
  /// Replaces v by the closest velocity, in the kinetic-energy norm, that opens no loop. Like project_velocity(), but accurate to rounding.
  /// @param v [nv, in and out] m/s | rad/s
  void project(const Mechanism& m, Workspace& ws, ClosedLinks& closed, std::span<double> v);

 private:
  void refine(const Mechanism& m, Workspace& ws, ClosedLinks& closed, std::span<const double> r, std::span<const double> v,
              std::span<double> x);
  void calc_residual(const Mechanism& m, Workspace& ws, const ClosedLinks& closed, std::span<const double> r, std::span<const double> x,
                     bool with_loops);
  void balance_trees(const Mechanism& m, Workspace& ws, const ClosedLinks& closed, std::span<const double> r, std::span<double> x);

  std::vector<double> residual_, delta_, sum_, change_, zero_;  // [nv] scratch
  std::vector<double> lambda_;                                  // [rows of all loops] multipliers, N s | N m s
  std::vector<int> tree_;                                       // [links] root link of the link's tree
  std::vector<char> tied_;  // [links] at root links: 1 if a loop connects the tree to the world or to another tree
};

}  // namespace ugoki::dynamics
