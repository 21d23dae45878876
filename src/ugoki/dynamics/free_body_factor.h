#pragma once
// Factor of the inertia matrix of a mechanism that is one free rigid body, in closed form.
//
// The DOFs of a floating joint are the angular velocity w in body axes and the velocity of the body's origin in the axes of the joint.
// About the centre of mass the inertia matrix is diag(I_c, m 1), with the constant inertia I_c = L^T D L in body axes. A force f and a
// moment t about the origin therefore have the whitened row
//   y_w = D^-1/2 L^-T R^T (t - c x f),   y_v = f / sqrt(m)
// R is the orientation of the body and c its centre of mass relative to the origin. ArticulatedFactor (articulated_factor.h) uses these
// formulas where they apply; they need a fifth of the operations of its recursion and give the same factor.
// Source: Featherstone, Rigid Body Dynamics Algorithms (2008), section 2.13.

#include <array>
#include <span>

#include "ugoki/dynamics/workspace.h"

namespace ugoki::dynamics {

/// The functions have the contracts of those of ArticulatedFactor, for 6 DOFs.
class FreeBodyFactor {
 public:
  explicit FreeBodyFactor(const Mechanism& m);

  /// Whether the mechanism is one link with mass on a floating joint without armature.
  static bool applies_to(const Mechanism& m);

  [[nodiscard]] int factor(const Workspace& ws);
  void solve(std::span<double> x) const;
  void whiten_wrenches(int last, const Vec6* f, double* y) const;
  void whiten_row(int last, std::span<const double> tail, double* y) const;
  void add_whitened(std::span<const double> w, std::span<double> v) const;
  void whiten_velocity(std::span<const double> v, std::span<double> w) const;
  [[nodiscard]] double pivot(std::size_t k) const { return D_[k]; }
  [[nodiscard]] double inverse_pivot(std::size_t k) const { return D_inverse_[k]; }

 private:
  /// Velocity of the centre of mass relative to the origin, in the axes of the joint. @param w angular velocity, body axes
  [[nodiscard]] Vec3 centre_velocity(const Vec3& w) const;
  /// Moment about the centre of mass, body axes. @param moment about the origin, body axes @param force in the axes of the joint
  [[nodiscard]] Vec3 centre_moment(const Vec3& moment, const Vec3& force) const;

  std::array<double, 6> D_{}, D_inverse_{}, root_{};  // diagonal D and m, 1 / D, D^-1/2
  double l10_ = 0, l20_ = 0, l21_ = 0;                // L of I_c, below the unit diagonal
  int singular_ = -1;                                 // DOF whose pivot is not positive; -1: none
  bool centred_ = true, turned_ = false;              // the centre of mass is the origin; the joint's axes are not those of the world
  Vec3 c_B_;                                          // m: centre of mass in body axes
  Mat3 T_;                                            // orientation of the joint's axes in the world
  Mat3 R_;                                            // orientation of the body in the world, at the last call of factor()
  Vec3 c_W_;                                          // m: centre of mass from the origin, world axes
};

}  // namespace ugoki::dynamics
