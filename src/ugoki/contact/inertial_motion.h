#pragma once
// Motion of a fast linked system under its inertial forces alone.
//
// The step of a system whose joints turn by more than InertialMotion::threshold in a step is split: all forces and impulses change the
// velocity first, with the bias forces of zero velocity, and then the system moves without forces,
//   M(q) vdot + b(q, v) = 0 without gravity,   q' = v,   and for closed systems the loops' constraints with their forces.
// One evaluation of b per step, at any velocity, lets the energy of fast chains grow or makes the step diverge. Open systems are integrated
// by the classical Runge-Kutta method of order 4. In a substep it loses a fraction of about turn^6 / 144 of the energy of a rotation, 4e-7
// at 0.2 rad [Hairer, Wanner II, section IV.2: its stability function at an imaginary argument]. Rotations are integrated as rotation
// vectors from the substep's start. Closed systems move in shorter substeps with impulses in their loops.
// Sources: Hairer, Norsett, Wanner, Solving ordinary differential equations I (1993), section II.1; Iserles, Munthe-Kaas, Norsett, Zanna
// (2000), Lie-group methods.

#include <span>
#include <vector>

#include "ugoki/dynamics/closed_links.h"
#include "ugoki/dynamics/workspace.h"

namespace ugoki::contact {

/// Integrates the motion of one system without forces. Allocates in its constructor only.
class InertialMotion {
 public:
  /// rad: systems with a joint that turns further in a step are integrated by this class. With 0.1 the energy of free chains of three
  /// bodies changes by 10 % in 2 s, with 0.02 by less than 1 % (linked_test.cpp).
  static constexpr double threshold = 0.02;

  explicit InertialMotion(const Mechanism& m);

  /// rad: maximum rotation of a joint, or of a floating base, within dt at the velocities v.
  [[nodiscard]] double turn(std::span<const double> v, double dt) const;

  /// Moves the system for dt [s] in substeps.
  /// @param ws scratch memory of the kernels; the results of update_kinematics() in it stay valid
  /// @param closed loops of a closed system, which the motion keeps closed; null: open
  /// @param q [nq] in: start, out: end @param v [nv] in: start, out: end
  /// @param gap [in and out] m | rad: raised to the maximum gap of a loop after the motion
  /// @return false if an acceleration is singular or not finite, or a loop cannot be closed; q and v then have their values from the start
  [[nodiscard]] bool move(const Mechanism& m, dynamics::Workspace& ws, dynamics::ClosedLinks* closed, std::span<double> q,
                          std::span<double> v, double dt, double& gap);

 private:
  double kinetic_energy(const Mechanism& m, std::span<const double> q, std::span<const double> v);
  bool step_open(const Mechanism& m, dynamics::Workspace& ws, std::span<double> q, std::span<double> v, double h);
  bool step_closed(const Mechanism& m, dynamics::ClosedLinks& closed, std::span<double> q, std::span<double> v, double h, double& gap);

  std::vector<std::size_t> angles_;              // DOFs that are angles
  std::vector<std::size_t> rotations_;           // first DOF of each rotation by a quaternion
  std::vector<double> zeros_;                    // [nv]
  std::vector<double> u_, rate_, a_;             // [nv] displacement, its rate, acceleration of a stage
  std::vector<double> stage_v_, sum_u_, sum_v_;  // [nv] velocity of a stage; weighted sums of the rates
  std::vector<double> stage_q_, start_q_;        // [nq]
  std::vector<double> start_v_;                  // [nv]
  std::vector<dynamics::Workspace> closing_;     // closed systems: one
};

}  // namespace ugoki::contact
