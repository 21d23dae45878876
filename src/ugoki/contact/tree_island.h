#pragma once
// Impulses of a large link system that touches only the ground, at a cost linear in its number of links, with or without closed loops.
//
// The unknown is the velocity change d = v' - v_free of the system; V_i = J_i d is that of link i [6]. For fixed p^, Newton's method solves
//   F(d) = M' d - sum J^T p(u) - J_L^T lambda = 0,   J_L d = 0,   u = target + J d
// where p(u) is the augmented law of each block (augmented_law.h), and J_L, lambda are the rows and multipliers of the closed loops. F is
// the gradient of a convex function, the merit; a line search along each Newton step looks for the zero of its slope. velocity_newton.cpp
// solves the same equation in whitened coordinates, where a row has an entry for each DOF on the chain of its link, and a system with deep
// chains has a dense matrix. Here a contact has entries only at its own link: the Newton matrix is
//   M' + sum_i J_i^T K_i J_i + diag,   K_i = sum W^T G W,  G = -dp/du,  W: rows of the contacts of link i [3 x 6]
// i.e. the inertia of the same system with stiffer links, which the articulated-body recursion with loops factors (dynamics/stiff_links.h).
// The inverse inertia B = W Omega_i W^T of each block, which scales its law and its compliance, comes from the same recursion.
//
// Not possible with this method: contacts between two links that both move (K couples links that are not neighbours), grips, and limits of
// spherical joints (they couple the DOFs of a joint). Stepper solves such systems by whitened rows (velocity_solver.h).
// Sources: velocity_solver.h; Featherstone (2008), ch. 7, 8.

#include <span>
#include <vector>

#include "ugoki/contact/anderson_mixing.h"
#include "ugoki/contact/row_block.h"
#include "ugoki/contact/velocity_solver.h"
#include "ugoki/dynamics/articulated_factor.h"
#include "ugoki/dynamics/stiff_links.h"

namespace ugoki::contact {

class TreeIsland {
 public:
  explicit TreeIsland(const Mechanism& m);

  /// DOFs from which on this method is used. Below, whitened rows are faster.
  static constexpr int min_dofs = 48;
  /// Sum over the contacts of the squared chain length, relative to the number of DOFs, from which on this method is used for a system
  /// without closed loops. The cost of whitened rows grows with this sum.
  static constexpr double min_work = 600;

  /// Whether the method can treat the joints of the mechanism.
  [[nodiscard]] static bool can_treat(const Mechanism& m);

  /// Begins a step: removes all blocks and factors the inertia with closed loops. Call update_kinematics() and share_virtual_inertias()
  /// first. `m` and `ws` are those of all other calls in this step.
  /// @param open factor of the inertia without loops; must stay valid during the step
  /// @param extra [nv] kg | kg m^2, added to the inertia @param closing_speed m/s | rad/s: maximum speed at which loops close
  /// @return velocity index of a DOF that moves no inertia, or -1
  [[nodiscard]] int begin(const Mechanism& m, dynamics::Workspace& ws, std::span<const double> q, std::span<const double> v,
                          const dynamics::ArticulatedFactor& open, std::span<const double> extra, double closing_speed, double dt);
  /// Replaces the impulse r [N s | N m s] by the velocity after it, at which the loops close. @param v [nv] velocity before
  void move(const Mechanism& m, dynamics::Workspace& ws, std::span<const double> v, std::span<double> r);

  /// Adds a contact of `link` with the ground.
  /// @param wrenches [3] unit wrenches about p0 (normal, tangents) @param target, warm as VelocitySolver::end_block()
  RowBlock& add_contact(std::uint64_t key, int link, std::span<const Vec6, 3> wrenches, std::span<const double, 3> target,
                        std::span<const double> warm);
  /// Adds a limit or dry friction of one DOF. @param sign 1 or -1: direction of the row
  RowBlock& add_joint_row(RowKind kind, std::uint64_t key, int dof, double sign, double target, std::span<const double> warm);

  /// Solves the impulses of all blocks, starting from the present ones. Adds to `report`; not_converged counts the system.
  /// The number of factorizations is bounded (tree_island.cpp). @param max_newton_steps after these, no update of p^ begins
  void solve(const Mechanism& m, dynamics::Workspace& ws, const SolverOptions& options, int max_newton_steps, SolverReport& report);

  /// [nv] velocity change of the last solve(); zero without blocks.
  [[nodiscard]] std::span<const double> change() const { return change_; }
  [[nodiscard]] std::span<const RowBlock> blocks() const { return blocks_; }
  [[nodiscard]] std::span<const double> impulses(const RowBlock& b) const {
    return std::span(p_).subspan(static_cast<std::size_t>(b.row), static_cast<std::size_t>(b.rows));
  }

 private:
  /// Where a block acts: contact: on `link` with the wrenches W; limit and friction: on `dof` with the sign W[0].w.x.
  struct Place {
    int link, dof;
    bool held;  // loops keep the block from moving; it has no impulse
    Vec6 W[3];
  };
  struct Slope {
    double laws, curvature;  // of the blocks along a step: sum (p - old_p_) . du, sum du . G du
  };

  RowBlock& add_block(RowKind kind, std::uint64_t key, const Place& place, std::span<const double> target, std::span<const double> warm);
  void finish_blocks(const Mechanism& m, dynamics::Workspace& ws, double softness);
  void find_change(const Mechanism& m, dynamics::Workspace& ws);
  void find_velocities(std::span<const Vec6> links, std::span<const double> dofs, std::span<double> u) const;
  [[nodiscard]] double measure() const;
  int newton(const Mechanism& m, dynamics::Workspace& ws, double tolerance, int limit);
  int minimise(const Mechanism& m, dynamics::Workspace& ws, double tolerance);
  Slope apply_laws(double length);
  void assemble(const dynamics::Workspace& ws);

  dynamics::StiffLinks solver_;
  const dynamics::ArticulatedFactor* open_ = nullptr;
  bool base_factor_ = false;             // the last factorization was that of M', without stiffness
  std::size_t finished_ = 0;             // blocks whose inverse inertia is known
  std::vector<double> extra_, closing_;  // [nv]; [rows of all loops] m/s | rad/s
  std::vector<RowBlock> blocks_;
  std::vector<Place> places_;                    // [blocks]
  std::vector<double> target_, p_, hat_;         // [rows] hat_: p^
  std::vector<double> old_p_;                    // [rows] impulses at the beginning of a Newton step
  std::vector<double> u_, du_;                   // [rows] velocities, and their change along step_
  std::vector<double> shift_, next_shift_;       // [blocks] AugmentedLaw::shift, and that of the last velocities
  std::vector<double> G_;                        // [blocks * 9] -dp/du, row by row
  AndersonMixing mixing_;                        // of the shifts
  std::vector<double> change_, step_;            // [nv] d, Newton step
  std::vector<Vec6> change_V_, step_V_;          // [links] velocity changes of the links
  std::vector<double> r_, stiff_extra_;          // [nv] impulse on the DOFs; extra_ with the stiffness of joint rows
  std::vector<Vec6> wrenches_;                   // [links] minus the impulses on the links
  std::vector<dynamics::ArticulatedInertia> K_;  // [links] stiffness
  double regularization_ = 0;                    // R as a fraction of a block's inverse inertia
  std::vector<double> best_p_, best_change_;     // of the smallest residual so far
};

}  // namespace ugoki::contact
