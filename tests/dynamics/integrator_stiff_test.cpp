#include <gtest/gtest.h>

#include <cmath>

#include "integrator_scenes.h"
#include "ugoki/dynamics/dynamics.h"

namespace ugoki::dynamics {
namespace {

using testing::adaptive;
using testing::fixed;
using Method = IntegrationMethod;
using Status = IntegrationStatus;

constexpr double g = 9.81;

// m x'' = -k (x - rest) - d x' - m g with k = 1e6 N/m and d = 1e4 N s/m: two exponential decays, one with a rate of 1e4 per second.
TEST(StiffSystems, HardSpringAndHeavyDamperMatchClosedForm) {
  Dof f;
  f.stiffness = 1e6;
  f.damping = 1e4;
  OpenSystem system(testing::sliders(1, f), {.joint_forces = {}, .exact_jacobian = true});
  const double root = std::sqrt(0.25e8 - 1e6), fast = -5e3 - root, slow = -5e3 + root, rest = -g / 1e6;
  const auto exact = [&](double t) {
    const double A = fast / (fast - slow) * (1 - rest);  // x(0) = 1, x'(0) = 0
    return rest + A * std::exp(slow * t) + (1 - rest - A) * std::exp(fast * t);
  };
  const double q[] = {1}, v[] = {0};
  long evaluations[2] = {};
  for (const Method method : {Method::dormand_prince_54, Method::radau_iia_5}) {
    Integrator integrator(system, adaptive(method, 1e-6));
    integrator.start(0, q, v);
    for (const double t : {0.001, 0.01, 0.1, 5.0}) {
      ASSERT_EQ(integrator.advance(t).status, Status::reached);
      EXPECT_NEAR(integrator.q()[0], exact(t), 1e-5) << t;
    }
    evaluations[method == Method::radau_iia_5] = integrator.statistics().accelerations;
    RecordProperty(method == Method::radau_iia_5 ? "radau_steps" : "dormand_prince_steps", static_cast<int>(integrator.statistics().steps));
  }
  EXPECT_GT(evaluations[0], 50'000);
  EXPECT_LT(evaluations[1], 1'000);
}

// A whip with one joint held by a spring of 1e6 N m/rad. The implicit method is compared with an explicit one of similar tolerance.
TEST(StiffSystems, LinkHeldByHardSpringMatchesExplicitMethod) {
  MechanismSpec spec;
  spec.name = "whip";
  for (int i = 0; i < 3; ++i) {
    LinkSpec l = testing::point_link("", i > 0 ? spec.links.back().name.c_str() : "", i == 2 ? JointType::spherical : JointType::revolute,
                                     {0, 1, 0}, {0, 0.05, -0.3}, 0.5);
    l.name = "rod" + std::to_string(i);
    l.inertia.I = l.inertia.I + Sym3{1e-3, 1e-3, 1e-3, 0, 0, 0};
    l.joint.X_PJ.p = {0, 0, i > 0 ? -0.5 : 0.0};
    l.joint.dofs[0].damping = i == 1 ? 1e4 : 0.01;
    l.joint.dofs[0].stiffness = i == 1 ? 1e6 : 0.0;
    l.joint.dofs[0].rest = i == 1 ? 0.3 : 0.0;
    spec.links.push_back(l);
  }
  const MechanismPtr m = Mechanism::make(std::move(spec)).value();
  State s(*m);
  s.q[0] = 1.2;
  s.q[1] = 0.3;
  s.v[0] = 2;
  s.v[3] = 1;
  std::vector<double> ends[3];
  long accelerations[3] = {};
  for (int i = 0; i < 3; ++i) {
    OpenSystem system(m, {.joint_forces = {}, .exact_jacobian = i == 2});
    Integrator integrator(system, adaptive(i == 0 ? Method::dormand_prince_54 : Method::radau_iia_5, i == 0 ? 1e-9 : 1e-8));
    integrator.start(0, s.q, s.v);
    ASSERT_EQ(integrator.advance(0.3).status, Status::reached);
    ends[i].assign(integrator.q().begin(), integrator.q().end());
    accelerations[i] = integrator.statistics().accelerations;
  }
  for (int i = 1; i < 3; ++i)
    for (std::size_t k = 0; k < ends[0].size(); ++k) EXPECT_NEAR(ends[i][k], ends[0][k], 2e-6) << "jacobian " << i << " coordinate " << k;
  EXPECT_GT(accelerations[0], 50 * accelerations[2]);
  EXPECT_LT(accelerations[2], accelerations[1]);
  RecordProperty("dormand_prince", static_cast<int>(accelerations[0]));
  RecordProperty("radau_numerical", static_cast<int>(accelerations[1]));
  RecordProperty("radau_exact", static_cast<int>(accelerations[2]));
}

// Van der Pol's oscillator with mu = 1000, in scaled time: a sliding mass driven by x'' = ((1 - x^2) x' - x) / 1e-6.
// Reference: y(2) = 0.17061677321e1 (Mazzia, Magherini, Test set for IVP solvers 2.4).
TEST(StiffSystems, VanDerPolMatchesPublishedSolution) {
  class VanDerPol final : public OpenSystem {
   public:
    VanDerPol() : OpenSystem(testing::sliders(1), {.gravity = {}, .joint_forces = {}}) {}
    void calc_drive(double, std::span<const double> q, std::span<const double> v, std::span<double> tau) override {
      tau[0] = ((1 - q[0] * q[0]) * v[0] - q[0]) * 1e6;
    }
  } system;
  Integrator integrator(system, adaptive(Method::radau_iia_5, 1e-8));
  const double q[] = {2}, v[] = {0};
  integrator.start(0, q, v);
  ASSERT_EQ(integrator.advance(2).status, Status::reached);
  EXPECT_NEAR(integrator.q()[0], 1.706167732170483, 1e-6);
  EXPECT_NEAR(integrator.v()[0], -0.8928097010248125, 1e-6);
  EXPECT_LT(integrator.statistics().steps, 2000);
  RecordProperty("steps", static_cast<int>(integrator.statistics().steps));
}

}  // namespace
}  // namespace ugoki::dynamics
