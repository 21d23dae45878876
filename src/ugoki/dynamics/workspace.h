#pragma once
// Memory of the dynamics algorithms for one mechanism: owned by the caller, sized at construction, one per thread.
//
// All spatial quantities that update_kinematics() stores here are in world axes about one reference point p0 (the first link's origin).
// The recursions therefore need no transforms between links. The tree of DOFs is stored as chains that start at the root: row i of the
// inertia matrix and of its factor has an entry for each DOF on the path from the base to DOF i. The chain of an ancestor is a prefix of
// the chain of i, so the inner loops run over contiguous memory.

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

/// 64 bytes of memory, aligned to a cache line.
struct alignas(64) CacheLine {
  std::byte bytes[64];
};

/// Compiled mechanism, results of the kinematics, inertia matrix and scratch memory.
/// Results of update_kinematics(). Spatial quantities are about p0, in world axes, angular part first.
struct Kinematics {
  explicit Kinematics(const Mechanism& mechanism);

  Vec3 p0;                 ///< m, world: the reference point
  std::vector<Pose> X_WB;  ///< [links] poses in the world
  std::vector<Vec6> S;     ///< [nv] column of the motion subspace
  std::vector<Vec6> V;     ///< [links] velocity: rad/s, m/s
  std::vector<Vec6> C;     ///< [links] velocity-product acceleration (dS/dt) v of the link relative to its parent
  std::vector<Inertia> I;  ///< [links] inertia about p0
};

struct Workspace : Kinematics {
  explicit Workspace(const Mechanism& mechanism);

  /// Allocates and fills `chain` and `entry_index`, and allocates M and L: O(nv depth) memory. The constructor calls this function for
  /// up to a million entries; for larger mechanisms the first call of calc_inertia_rows() calls it.
  void make_rows(const Mechanism& mechanism);

  /// Index in M and L of the entry of DOFs i and j, one of which must be an ancestor of the other, or the same.
  [[nodiscard]] int entry_of(int i, int j) const;

  // Structure of the mechanism
  LinkProgram program;           ///< the mechanism compiled for the fast kernels
  LinkTwins twins;               ///< `program` split into trunk and pairs of equal subtrees, for calls on one instance
  std::vector<int> depth;        ///< [nv] number of ancestors of DOF i
  std::vector<int> row_start;    ///< [nv + 1] first entry of row i in `chain`, `M`, `L`; row i has depth[i] + 1 entries
  std::vector<int> chain;        ///< row i: the DOFs on the path from the base to DOF i, i included
  std::vector<int> entry_index;  ///< [entries of M] index in M of each entry, in the order in which kernel_inertia.h computes them
  std::vector<int> link_chain;   ///< [links] DOF closest to the link among those that move it; -1: none
  std::vector<Dof> dofs;         ///< [nv] limits, armature and other properties of each DOF
  std::vector<double> armature;  ///< [nv] kg | kg m^2, armature of each DOF

  // Scratch memory of the recursions over links
  std::vector<Vec6> A, F;              ///< [links] accelerations, forces
  std::vector<Inertia> Ic;             ///< [links] composite inertia
  std::vector<ArticulatedInertia> IA;  ///< [links] articulated-body inertia
  std::vector<Vec6> pA;                ///< [links] articulated-body bias force
  std::vector<Vec6> U;                 ///< [nv] articulated-body inertia times motion subspace
  std::vector<double> d, u;            ///< [nv] inverse pivots, reduced joint forces

  // Inertia matrix and its factor M + diag = L^T D L, rows as in `chain`
  std::vector<double> M;          ///< inertia matrix, computed by calc_inertia_rows()
  std::vector<double> L;          ///< unit lower factor, computed by factor(); the diagonal entries contain D
  std::vector<double> D_inverse;  ///< [nv] reciprocals of D

  std::vector<CacheLine> scratch;  ///< memory of the fast kernels
};

}  // namespace ugoki::dynamics
