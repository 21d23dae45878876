#pragma once
// Scratch memory of the dynamics algorithms for one mechanism; caller-owned, sized once, one a thread.
//
// All spatial quantities that update_kinematics() leaves here are in world axes about ONE reference point p0 (the first link's origin), so
// that the recursions need no transforms between links. The tree of freedoms is kept as root-first chains: row i of the inertia matrix and
// of its factor has an entry for each freedom on the path from the base to i, and the chain of an ancestor is a prefix of it, so the inner
// loops run over contiguous memory.

#include <cstddef>
#include <span>
#include <vector>

#include "ugoki/dynamics/link_twins.h"

namespace ugoki::dynamics {

/// Articulated-body inertia, symmetric 6 x 6: [[I, H], [H^T, M]], angular first.
struct ArticulatedInertia {
  Sym3 I;
  Mat3 H;
  Sym3 M;
};

/// A piece of memory that starts a cache line.
struct alignas(64) CacheLine {
  std::byte bytes[64];
};

struct Workspace {
  explicit Workspace(const Mechanism& mechanism);

  /// Makes `chain`, `entry_place`, M and L, which take O(nv depth) memory. The constructor does it up to a million entries, and
  /// calc_inertia_rows() where it was not done yet.
  void make_rows(const Mechanism& mechanism);

  /// Where the entry of freedoms i and j, of which one moves the other, stands in M and L.
  [[nodiscard]] int place_of(int i, int j) const;

  // From the mechanism
  LinkProgram program;            ///< what the fast kernels run
  LinkTwins twins;                ///< the same for one instance, with legs and arms side by side
  std::vector<int> depth;         ///< [nv] freedoms above freedom i
  std::vector<int> row_start;     ///< [nv + 1] first entry of row i in `chain`, `M`, `L`; row i has depth[i] + 1 entries
  std::vector<int> chain;         ///< freedoms from the base to i, i included
  std::vector<int> entry_place;   ///< [entries of M] where they stand, in the order in which kernel_inertia.h has them
  std::vector<int> link_chain;    ///< [links] deepest freedom that moves the link, or -1
  std::vector<Freedom> freedoms;  ///< [nv]

  // Kinematics: update_kinematics()
  Vec3 p0;                 ///< m, world
  std::vector<Pose> X_WB;  ///< [links]
  std::vector<Vec6> S;     ///< [nv] motion subspace
  std::vector<Vec6> V;     ///< [links] velocity
  std::vector<Vec6> C;     ///< [links] (dS/dt) v: velocity-product acceleration of the link relative to its parent
  std::vector<Inertia> I;  ///< [links]

  // Scratch of the recursions
  std::vector<Vec6> A, F;              ///< [links]
  std::vector<Inertia> Ic;             ///< [links] composite inertia
  std::vector<ArticulatedInertia> IA;  ///< [links]
  std::vector<Vec6> pA;                ///< [links] articulated bias force
  std::vector<Vec6> U;                 ///< [nv] articulated inertia times motion subspace
  std::vector<double> d, u;            ///< [nv] inverse pivots, reduced joint forces

  // Inertia matrix and its factor M + diag = L^T D L, rows as in `chain`
  std::vector<double> M;          ///< calc_inertia_rows()
  std::vector<double> L;          ///< factor(): unit lower factor; the diagonal entries hold D
  std::vector<double> D_inverse;  ///< [nv]

  std::vector<CacheLine> scratch;  ///< of the functions that start from q and v
};

}  // namespace ugoki::dynamics
