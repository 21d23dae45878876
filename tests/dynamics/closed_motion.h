#pragma once
// Motions of closed link systems for the tests.

#include <functional>

#include "benchmark_mechanisms.h"
#include "ugoki/dynamics/closed_reference_system.h"
#include "ugoki/dynamics/integrators.h"

namespace ugoki::testing {

using JointForces = std::function<void(const std::vector<double>& q, const std::vector<double>& v, std::vector<double>& tau)>;

/// A closed link system under joint forces that depend on its state.
class ForcedSystem : public dynamics::ClosedReferenceSystem {
 public:
  ForcedSystem(const ClosedCase& c, JointForces forces) : ClosedReferenceSystem(c.mechanism, options_for(c)), forces_(std::move(forces)) {}
  void calc_drive(double t, std::span<const double> q, std::span<const double> v, std::span<double> tau) override {
    if (!forces_) return ClosedReferenceSystem::calc_drive(t, q, v, tau);
    std::vector<double> at_q(q.begin(), q.end()), at_v(v.begin(), v.end()), out(tau.size());
    forces_(at_q, at_v, out);
    std::ranges::copy(out, tau.begin());
  }

 private:
  static dynamics::OpenSystemOptions options_for(const ClosedCase& c) {
    dynamics::OpenSystemOptions options;
    options.gravity = c.gravity;
    return options;
  }
  JointForces forces_;
};

/// Integrates a ClosedCase, by default with fixed steps of the Dormand-Prince method (order 5).
class ClosedMotion {
 public:
  explicit ClosedMotion(const ClosedCase& c, double step, JointForces forces = {}) : ClosedMotion(c, fixed(step), std::move(forces)) {}
  ClosedMotion(const ClosedCase& c, const dynamics::IntegratorOptions& options, JointForces forces = {})
      : system(c, std::move(forces)), integrator(system, options) {
    integrator.start(0, c.q, c.v);
  }

  /// Integrates to time t. @return false on failure
  bool advance(double t) { return integrator.advance(t).status == dynamics::IntegrationStatus::reached; }

  [[nodiscard]] double q(int i) const { return integrator.q()[static_cast<std::size_t>(i)]; }
  [[nodiscard]] double v(int i) const { return integrator.v()[static_cast<std::size_t>(i)]; }
  double energy() { return system.calc_energy(integrator.q(), integrator.v()); }
  /// Maximum gap of any constraint row [m | rad].
  double gap() {
    update_gaps(system.mechanism(), integrator.q(), system.closed);
    return measure_gap(system.closed).gap;
  }

  static dynamics::IntegratorOptions fixed(double step) {
    dynamics::IntegratorOptions options;
    options.step = step;
    options.adaptive = false;
    return options;
  }

  ForcedSystem system;
  dynamics::Integrator integrator;
};

/// Integrates for `duration` and measures, at `samples` times, the maximum drift of the energy [J] and the maximum gap [m | rad].
struct Drift {
  double energy = 0, gap = 0;

  Drift(ClosedMotion& motion, double duration, int samples) {
    const double start = motion.energy();
    for (int k = 1; k <= samples; ++k) {
      reached = reached && motion.advance(duration * k / samples);
      energy = std::max(energy, std::fabs(motion.energy() - start));
      gap = std::max(gap, motion.gap());
    }
  }
  bool reached = true;
};

}  // namespace ugoki::testing
