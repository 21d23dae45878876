#pragma once
// Runge-Kutta steps of closed link systems for the tests, and their energy.

#include <functional>

#include "benchmark_mechanisms.h"
#include "ugoki/dynamics/closed_reference.h"
#include "ugoki/dynamics/dynamics.h"

namespace ugoki::testing {

using JointForces = std::function<void(const std::vector<double>& q, const std::vector<double>& v, std::vector<double>& tau)>;

/// A closed link system that moves in steps; the state is closed after each.
struct ClosedMotion {
  explicit ClosedMotion(const ClosedCase& c) : m(*c.mechanism), cw(m), q(c.q), v(c.v), gravity(c.gravity), tau(v.size()) {}

  const Mechanism& m;
  dynamics::ClosedWorkspace cw;
  std::vector<double> q, v;
  Vec3 gravity;
  std::vector<double> tau;
  JointForces forces = {};

  bool acceleration(const std::vector<double>& at_q, const std::vector<double>& at_v, std::vector<double>& a) {
    if (forces) forces(at_q, at_v, tau);
    return dynamics::calc_closed_acceleration(m, cw, at_q, at_v, tau, gravity, {}, a);
  }

  /// The classical method of order 4, in coordinates without quaternions (q' = v).
  bool step(double dt) {
    const std::size_t n = v.size();
    std::vector<double> q1 = q, v1 = v, dq(n), dv(n), a(n);
    constexpr double stage[4] = {0, 0.5, 0.5, 1}, weight[4] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};
    for (int j = 0; j < 4; ++j) {
      if (j > 0)
        for (std::size_t i = 0; i < n; ++i) {
          q1[i] = q[i] + stage[j] * dt * v1[i];
          v1[i] = v[i] + stage[j] * dt * a[i];
        }
      if (!acceleration(q1, v1, a)) return false;
      for (std::size_t i = 0; i < n; ++i) {
        dq[i] += weight[j] * dt * v1[i];
        dv[i] += weight[j] * dt * a[i];
      }
    }
    for (std::size_t i = 0; i < n; ++i) {
      q[i] += dq[i];
      v[i] += dv[i];
    }
    return dynamics::project_closed_state(m, q, v, cw).closed;
  }

  double energy() {
    dynamics::update_kinematics(m, q, v, cw.open);
    return dynamics::kinetic_energy(m, cw.open) + dynamics::potential_energy(m, cw.open, gravity);
  }
  /// Greatest gap of any row [m | rad].
  double gap() {
    dynamics::update_kinematics(m, q, v, cw.open);
    dynamics::update_loop_rows(m, cw.open, cw.loops, q, v, cw.rows);
    return dynamics::measure_gap(cw).gap;
  }
};

}  // namespace ugoki::testing
