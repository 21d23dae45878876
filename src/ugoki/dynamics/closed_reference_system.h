#pragma once
// A closed link system as a MotionSystem for the integrators, computed by the method of Nagashima (1999, closed_reference.h). Each stage
// moves the independent DOFs theta_G and solves exactly for the dependent DOFs theta_S.

#include "ugoki/dynamics/closed_reference.h"
#include "ugoki/dynamics/open_system.h"

namespace ugoki::dynamics {

class ClosedReferenceSystem : public OpenSystem {
 public:
  explicit ClosedReferenceSystem(MechanismPtr mechanism, const OpenSystemOptions& options = {});

  /// @return -1 on success; 0 if A_G is singular or the loops do not close (no single DOF can be named)
  [[nodiscard]] int calc_acceleration(double t, std::span<const double> q, std::span<const double> v, std::span<double> vdot) override;
  /// @return false: exact derivatives exist for open systems only
  [[nodiscard]] bool calc_acceleration_jacobian(double, std::span<const double>, std::span<const double>, std::span<double>,
                                                std::span<double>) override {
    return false;
  }
  [[nodiscard]] Projection project(double t, std::span<double> q, std::span<double> v) override;

  ClosedWorkspace closed;
};

}  // namespace ugoki::dynamics
