#pragma once
// What an impulse does to a closed system, to rounding also where its loops are nearly singular or its masses very unequal.
//
//   M x = r + J^T lambda,   J x = 0
//
// The recursion of closed_links.h stiffens inertias by the loops; near a singular position that takes digits from the balance of momentum.
// So its answer is refined: what x leaves of both equations, summed up link by link, is solved for once more. A tree that no loop
// ties to the world or to another tree moves as a rigid body with the freedoms of its root: that opens no loop, and takes out what is left
// of the momentum. Source: Higham (2002), Accuracy and stability of numerical algorithms, ch. 12 (fixed precision iterative refinement).

#include <span>
#include <vector>

#include "ugoki/dynamics/closed_links.h"

namespace ugoki::dynamics {

/// Scratch for one mechanism with loops; one a thread.
class ClosedImpulse {
 public:
  /// x <- the jump of the velocities by an impulse, after factor_closed_links() and share_virtual_inertias().
  /// @param r [nv] N s | N m s, the impulse on the freedoms @param x [nv, out] must not alias r. O(links). Allocates nothing after the
  /// first call for so many freedoms
  void solve(const Mechanism& m, Workspace& ws, ClosedLinks& closed, std::span<const double> r, std::span<double> x);
  /// v <- the velocities nearest to v, in kinetic energy, that open no loop: project_velocity() to rounding.
  void project(const Mechanism& m, Workspace& ws, ClosedLinks& closed, std::span<double> v);

 private:
  void refine(const Mechanism& m, Workspace& ws, ClosedLinks& closed, std::span<const double> r, std::span<const double> v,
              std::span<double> x);
  void calc_rest(const Mechanism& m, Workspace& ws, const ClosedLinks& closed, std::span<const double> r, std::span<const double> x,
                 bool with_loops);
  void balance_trees(const Mechanism& m, Workspace& ws, const ClosedLinks& closed, std::span<const double> r, std::span<double> x);

  std::vector<double> rest_, delta_, sum_, change_, none_;  // [nv]
  std::vector<double> lambda_;                              // [rows]
  std::vector<int> tree_;                                   // [links] root of each
  std::vector<char> tied_;                                  // [links] roots: a loop ties the tree to the world or to another
};

}  // namespace ugoki::dynamics
