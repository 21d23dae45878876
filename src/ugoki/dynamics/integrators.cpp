#include "ugoki/dynamics/integrators.h"

namespace ugoki::dynamics {
namespace {

/// Rate of the rotation vector u of q0^-1 q when q turns with body angular velocity w, up to terms of order u^4.
Vec3 rotation_vector_rate(const Vec3& u, const Vec3& w) { return w + cross(u, w) * 0.5 + cross(u, cross(u, w)) * (1.0 / 12.0); }

/// Velocity v at displacement u from the step's start -> rate of u, freedom by freedom.
void displacement_rate(const Mechanism& m, std::span<const double> u, std::span<const double> v, std::span<double> rate) {
  for (std::size_t i = 0; i < v.size(); ++i) rate[i] = v[i];
  for (const Link& link : m.links()) {
    if (link.joint.type != JointType::spherical && link.joint.type != JointType::floating) continue;
    const auto f = static_cast<std::size_t>(link.v_index);
    const Vec3 r = rotation_vector_rate({u[f], u[f + 1], u[f + 2]}, {v[f], v[f + 1], v[f + 2]});
    rate[f] = r.x;
    rate[f + 1] = r.y;
    rate[f + 2] = r.z;
  }
}

}  // namespace

bool step_semi_implicit(const Mechanism& m, Workspace& ws, State& s, const Vec3& gravity, double dt) {
  update_kinematics(m, s.q, s.v, ws);
  if (!calc_forward_dynamics(m, ws, s.tau, gravity, s.external, ws.vdot)) return false;
  for (std::size_t i = 0; i < s.v.size(); ++i) {
    s.a[i] = ws.vdot[i];
    s.v[i] += dt * ws.vdot[i];
  }
  integrate(m, s.q, s.v, dt, s.q);
  s.time += dt;
  return true;
}

bool step_rk4(const Mechanism& m, Workspace& ws, State& s, const Vec3& gravity, double dt) {
  const std::size_t n = s.v.size();
  constexpr double stage[4] = {0, 0.5, 0.5, 1};
  constexpr double weight[4] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};
  for (std::size_t i = 0; i < n; ++i) ws.k_q[i] = ws.k_v[i] = ws.sum_q[i] = ws.sum_v[i] = 0;
  for (int j = 0; j < 4; ++j) {
    for (std::size_t i = 0; i < n; ++i) {
      ws.k_q[i] *= stage[j] * dt;  // displacement at which this stage is taken
      ws.v1[i] = s.v[i] + stage[j] * dt * ws.k_v[i];
    }
    integrate(m, s.q, ws.k_q, 1.0, ws.q1);
    update_kinematics(m, ws.q1, ws.v1, ws);
    if (!calc_forward_dynamics(m, ws, s.tau, gravity, s.external, ws.k_v)) return false;
    displacement_rate(m, ws.k_q, ws.v1, ws.bias);
    for (std::size_t i = 0; i < n; ++i) {
      ws.k_q[i] = ws.bias[i];
      ws.sum_q[i] += weight[j] * ws.k_q[i];
      ws.sum_v[i] += weight[j] * ws.k_v[i];
    }
  }
  integrate(m, s.q, ws.sum_q, dt, s.q);
  for (std::size_t i = 0; i < n; ++i) {
    s.a[i] = ws.sum_v[i];
    s.v[i] += dt * ws.sum_v[i];
  }
  s.time += dt;
  return true;
}

}  // namespace ugoki::dynamics
