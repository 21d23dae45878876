#pragma once
// A closed link system the paper's way as the integrators see it: their stages move theta_G, and theta_S follows exactly.

#include "ugoki/dynamics/closed_reference.h"
#include "ugoki/dynamics/open_system.h"

namespace ugoki::dynamics {

class ClosedReferenceSystem : public OpenSystem {
 public:
  explicit ClosedReferenceSystem(MechanismPtr mechanism, const OpenSystemOptions& options = {});

  /// @return 0 where no freedom can be named: a singular inertia on theta_G, or loops that do not close
  [[nodiscard]] int calc_acceleration(double t, std::span<const double> q, std::span<const double> v, std::span<double> vdot) override;
  /// The exact derivatives are those of open systems.
  [[nodiscard]] bool calc_acceleration_jacobian(double, std::span<const double>, std::span<const double>, std::span<double>,
                                                std::span<double>) override {
    return false;
  }
  [[nodiscard]] Projection project(double t, std::span<double> q, std::span<double> v) override;

  ClosedWorkspace closed;
};

}  // namespace ugoki::dynamics
