// Rows of derivatives of the humanoid's dynamics, including kinematics, and of one step of each integrator.

#include "scenes.h"
#include "table.h"
#include "ugoki/dynamics/centroidal.h"
#include "ugoki/dynamics/derivatives.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/dynamics/integrators.h"
#include "ugoki/dynamics/open_system.h"

namespace ugoki::benchmarks {
namespace {

void derivatives(Table& table) {
  const MechanismPtr m = make_humanoid();
  const State s = lively_state(*m);
  const std::size_t n = s.v.size();
  dynamics::Workspace ws(*m);
  dynamics::ForwardDerivatives d(*m, ws);
  const auto inverse = [&] {
    dynamics::update_kinematics(*m, s.q, s.v, ws);
    dynamics::calc_inverse_dynamics_derivatives(*m, ws, s.v, d.vdot, gravity, {}, d.inverse);
  };
  const auto forward = [&] {
    dynamics::update_kinematics(*m, s.q, s.v, ws);
    if (dynamics::calc_forward_dynamics_derivatives(*m, ws, s.v, s.tau, gravity, {}, d) >= 0) throw std::runtime_error("singular humanoid");
  };
  const auto inverse_inertia = [&] {
    dynamics::calc_inertia_rows(*m, ws, s.q);
    if (dynamics::factor(ws, {}) >= 0) throw std::runtime_error("singular humanoid");
    dynamics::calc_inverse_of_inertia(ws, d.dtau);
  };
  std::vector<Vec6> A_G(n);
  const auto centroidal = [&] {
    dynamics::update_kinematics(*m, s.q, s.v, ws);
    dynamics::calc_centroidal_matrix(*m, ws, A_G);
  };
  forward();
  // check by central differences of the accelerations along one DOF of each kind
  for (const std::size_t j : {std::size_t{0}, std::size_t{4}, n - 1}) {
    std::vector<double> step(n), q(s.q.size()), high(n), low(n), exact(n);
    step[j] = 1;
    const double h = 1e-6;
    integrate(*m, s.q, step, h, q);
    (void)dynamics::calc_forward_dynamics(*m, ws, q, s.v, s.tau, gravity, {}, high);
    integrate(*m, s.q, step, -h, q);
    (void)dynamics::calc_forward_dynamics(*m, ws, q, s.v, s.tau, gravity, {}, low);
    for (std::size_t i = 0; i < n; ++i) {
      high[i] = (high[i] - low[i]) / (2 * h);
      exact[i] = d.dq[i * n + j];
    }
    require_same(exact, high, 1e-6, "humanoid forward derivatives");
  }
  const std::vector<double> ns = measure({inverse, forward, inverse_inertia, centroidal});
  const char* names[] = {"humanoid derivatives of inverse", "humanoid derivatives of forward", "humanoid inverse of inertia",
                         "humanoid centroidal matrix"};
  for (std::size_t i = 0; i < ns.size(); ++i) table.add({.row = names[i], .ours_ns = ns[i], .peer = {}});
}
const RowRegistration register_derivatives(150, derivatives);

void steps(Table& table) {
  const MechanismPtr m = make_humanoid();
  const State s = lively_state(*m);
  using Method = dynamics::IntegrationMethod;
  const std::pair<Method, const char*> methods[] = {{Method::semi_implicit_euler, "humanoid step, semi-implicit Euler"},
                                                    {Method::runge_kutta_4, "humanoid step, Runge-Kutta 4"},
                                                    {Method::gauss_legendre_6, "humanoid step, Gauss-Legendre 6"},
                                                    {Method::radau_iia_5, "humanoid step, Radau IIA 5"}};
  for (const auto& [method, name] : methods) {
    dynamics::OpenSystem system(m, {.joint_forces = {}, .exact_jacobian = true});
    dynamics::IntegratorOptions options;
    options.method = method;
    options.step = 1e-3;
    options.adaptive = false;
    options.relative_tolerance = options.absolute_tolerance = 1e-8;
    dynamics::Integrator integrator(system, options);
    integrator.start(0, s.q, s.v);
    int taken = 0;
    const auto step = [&] {
      if (++taken % 100 == 0) integrator.start(0, s.q, s.v);
      if (integrator.advance(integrator.time() + 1e-3).status != dynamics::IntegrationStatus::reached) throw std::runtime_error(name);
    };
    table.add({.row = name, .ours_ns = measure({step})[0], .peer = {}});
  }
}
const RowRegistration register_steps(160, steps);

}  // namespace
}  // namespace ugoki::benchmarks
