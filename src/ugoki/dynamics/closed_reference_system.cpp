#include "ugoki/dynamics/closed_reference_system.h"

#include <algorithm>

namespace ugoki::dynamics {

ClosedReferenceSystem::ClosedReferenceSystem(MechanismPtr mechanism, const OpenSystemOptions& options)
    : OpenSystem(std::move(mechanism), options), closed(OpenSystem::mechanism()) {}

int ClosedReferenceSystem::calc_acceleration(double t, std::span<const double> q, std::span<const double> v, std::span<double> vdot) {
  calc_forces(t, q, v);
  return calc_closed_acceleration(mechanism(), closed, q, v, forces(), options().gravity, external, vdot) ? -1 : 0;
}

Projection ClosedReferenceSystem::project(double /*t*/, std::span<double> q, std::span<double> v) {
  std::ranges::copy(q, closed.q2.begin());
  std::ranges::copy(v, closed.v2.begin());
  if (!project_closed_state(mechanism(), q, v, closed).closed) return Projection::failed;
  return std::ranges::equal(q, closed.q2) && std::ranges::equal(v, closed.v2) ? Projection::kept : Projection::moved;
}

}  // namespace ugoki::dynamics
