#pragma once
// Factor of the inertia matrix of an open link system, computed without the matrix.
//
// M' = M + diag(extra) = L^T D L is the factor of dynamics.h. The articulated-body recursion yields the same D and, instead of L, the
// products U_k = IA_k S_k of the articulated-body inertia IA_k [6 x 6] and the motion subspace column S_k of each DOF k:
//   D_k = S_k . U_k + armature_k + extra_k,   IA of the parent DOF += IA_k - U_k U_k^T / D_k
// Products with L^-1 and L^-T are recursions along the tree. These recursions need 12 multiplications per DOF; the sparse L needs one for
// each ancestor of each DOF. The DOFs of one joint are eliminated one after the other, as if massless links connected them.
// All spatial vectors are in world axes about Workspace::p0, angular part first.
// A mechanism that is one free body has the same factor in closed form (free_body_factor.h).
// Sources: Featherstone, Rigid Body Dynamics Algorithms (2008), ch. 7; Rodriguez, Jain, Kreutz-Delgado (1991), A spatial operator algebra
// for manipulator modeling and control (the factor of M by articulated bodies).

#include <optional>
#include <span>
#include <vector>

#include "ugoki/dynamics/factor_kernels.h"
#include "ugoki/dynamics/free_body_factor.h"
#include "ugoki/dynamics/workspace.h"

namespace ugoki::dynamics {

/// Scratch memory of the recursions. One object can serve the factors of several mechanisms, one after the other.
struct FactorScratch {
  std::vector<Eight> inertias;  ///< [inertias][6] rows of the articulated-body inertias: symmetric matrices
  std::vector<Eight> sweep;     ///< [nv] forces or accelerations
};

/// Factor of the inertia matrix by articulated bodies. Allocates in its constructor only. O(nv) memory.
class ArticulatedFactor {
 public:
  explicit ArticulatedFactor(const Mechanism& m);

  /// Enlarges scratch memory for this factor.
  void make_room(FactorScratch& scratch) const;
  /// Uses `scratch`, for which make_room() was called, from now on, and releases the factor's own scratch memory. The processor's cache
  /// then holds one scratch memory instead of one for each factor. Factors that share scratch memory must not compute at the same time.
  void use(FactorScratch& scratch);

  /// Computes the factor at the kinematics in `ws` (update_kinematics of the same mechanism). O(nv).
  /// @param extra [nv] kg | kg m^2, added to the diagonal of M; or empty
  /// @return velocity index of the first DOF whose pivot is not positive (it moves no inertia), or -1
  [[nodiscard]] int factor(const Workspace& ws, std::span<const double> extra);

  /// x <- M'^-1 x. O(nv). @param x [nv, in and out]
  void solve(std::span<double> x) const;

  /// Whitens three constraint rows at once: y = D^-1/2 L^-T J^T for the rows J of three wrenches on the link that DOF `last` moves.
  /// O(chain length). @param f [3] wrenches of unit magnitude about p0
  /// @param y [chain length][4, out] one entry for each DOF of the chain, root first; lanes 0, 1, 2: the three rows; lane 3: zero
  void whiten_wrenches(int last, const Vec6* f, double* y) const;

  /// Whitens one row that is nonzero only at the last DOFs of the chain of DOF `last`. O(chain length).
  /// @param tail entries of J for the last tail.size() DOFs of the chain
  /// @param y [chain length][4, out] whitened entry of each DOF in lane 0, root first; the other lanes are zero
  void whiten_row(int last, std::span<const double> tail, double* y) const;

  /// v += L^-1 D^-1/2 w: adds the velocity change of the whitened impulse w. O(nv). @param w [nv] @param v [nv, in and out]
  void add_whitened(std::span<const double> w, std::span<double> v) const;

  /// w = D^1/2 L v: the whitened velocity of v, so that y . w = J v for a whitened row y. O(nv). @param v [nv] @param w [nv, out]
  void whiten_velocity(std::span<const double> v, std::span<double> w) const;

  /// D of DOF k, kg | kg m^2.
  [[nodiscard]] double pivot(std::size_t k) const { return closed_form_ ? body_->pivot(k) : dofs_[k].pivot; }
  /// 1 / D of DOF k, 1/kg | 1/(kg m^2).
  [[nodiscard]] double inverse_pivot(std::size_t k) const { return closed_form_ ? body_->inverse_pivot(k) : dofs_[k].inverse; }

 private:
  std::vector<FactorDof> dofs_;
  std::vector<int> first_link_, links_;  // links rigidly attached to each DOF: links_[first_link_[k]] to links_[first_link_[k + 1] - 1]
  // A DOF that no link is attached to and that has one child, for example within a floating joint, shares the inertia of the child
  // (FactorDof::inertia).
  std::vector<int> inertia_dof_;        // [inertias] DOF closest to the tips that uses the inertia
  std::optional<FreeBodyFactor> body_;  // empty: not one free body
  bool closed_form_ = false;            // the last factor is that of body_: nothing was added to the diagonal
  mutable FactorScratch own_;
  FactorScratch* shared_ = nullptr;  // null: own_ is used
  [[nodiscard]] FactorScratch& scratch() const { return shared_ != nullptr ? *shared_ : own_; }
};

}  // namespace ugoki::dynamics
