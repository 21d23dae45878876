#include "ugoki/dynamics/joint_forces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "integrator_scenes.h"
#include "ugoki/dynamics/dynamics.h"

namespace ugoki::dynamics {
namespace {

using testing::adaptive;
using testing::RandomSource;
using Method = IntegrationMethod;

/// A random tree with springs (a different one for each DOF), limits and effort limits. @param losses adds dampers and dry friction
MechanismPtr sprung(unsigned seed, bool losses) {
  RandomSource random(seed);
  MechanismSpec spec = random_spec(random, 7, {}, seed % 2 == 0);
  for (LinkSpec& l : spec.links)
    for (Dof& f : l.joint.dofs) {
      f.stiffness = random.uniform(5, 50);
      f.rest = random.uniform(-0.3, 0.3);
      f.lower = -0.6;
      f.upper = 0.5;
      f.effort = 15;
      f.damping = losses ? random.uniform(0, 0.5) : 0;
      f.friction = losses ? random.uniform(0, 0.5) : 0;
    }
  return Mechanism::make(std::move(spec)).value();
}

State start_of(const MechanismPtr& m, unsigned seed) {
  RandomSource random(seed);
  State s(*m);
  std::vector<double> step(s.v.size());
  for (double& x : step) x = random.uniform(-0.8, 0.8);
  integrate(*m, m->neutral(), step, 1.0, s.q);
  for (double& x : s.v) x = random.uniform(-1, 1);
  for (double& x : s.tau) x = random.uniform(-20, 20);
  return s;
}

// Springs and limits without losses conserve energy for every joint type: their forces are the negative gradient of the reported energy.
TEST(JointForces, AreTheGradientOfTheReportedEnergy) {
  JointForceOptions options;
  options.limit_dissipation = 0;
  int limits = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const MechanismPtr m = sprung(seed, false);
    const State s = start_of(m, seed);
    const std::vector<double> rest(s.v.size());
    std::vector<double> tau(s.v.size()), scratch(s.v.size()), unit(s.v.size()), q(s.q.size());
    const JointForceReport report = calc_joint_forces(*m, s.q, rest, {}, options, tau);
    limits += report.limits;
    EXPECT_EQ(report.loss, 0);
    for (std::size_t i = 0; i < tau.size(); ++i) {
      const auto energy = [&](double h) {
        unit[i] = 1;
        integrate(*m, s.q, unit, h, q);
        unit[i] = 0;
        const JointForceReport r = calc_joint_forces(*m, q, rest, {}, options, scratch);
        return r.spring_energy + r.limit_energy;
      };
      const double h = 1e-5;
      EXPECT_NEAR(-(energy(h) - energy(-h)) / (2 * h), tau[i], 1e-5 * (1 + std::fabs(tau[i])))
          << "seed " << seed << " degree of freedom " << i;
    }
  }
  EXPECT_GT(limits, 20);
}

// With all joint forces, the rate of the energy equals drive power minus loss.
TEST(JointForces, EnergyRateEqualsDrivePowerMinusLoss) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const MechanismPtr m = sprung(seed, true);
    const State s = start_of(m, seed);
    OpenSystem system(m);
    system.drive = s.tau;
    std::vector<double> vdot(s.v.size());
    ASSERT_EQ(system.calc_acceleration(0, s.q, s.v, vdot), -1);
    const JointForceReport report = system.joint_force_report();
    EXPECT_GT(report.loss, 0);
    EXPECT_GT(report.saturated, 0);
    const auto energy = [&](double t) {
      std::vector<double> q(s.q.size()), v(s.v.size()), mean(s.v.size());
      for (std::size_t i = 0; i < v.size(); ++i) {
        v[i] = s.v[i] + t * vdot[i];
        mean[i] = s.v[i] + 0.5 * t * vdot[i];
      }
      integrate(*m, s.q, mean, t, q);
      return system.calc_energy(q, v);
    };
    const double h = 1e-6, rate = (energy(h) - energy(-h)) / (2 * h), expected = report.drive_power - report.loss;
    EXPECT_NEAR(rate, expected, 1e-5 * (1 + std::fabs(expected))) << "seed " << seed;
  }
}

TEST(JointForces, SlopesMatchFiniteDifferences) {
  const JointForceOptions options;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const MechanismPtr m = sprung(seed, true);
    const State s = start_of(m, seed);
    std::vector<double> dq(s.v.size()), dv(s.v.size()), high(s.v.size()), low(s.v.size()), q(s.q.size()), unit(s.v.size());
    calc_joint_force_slopes(*m, s.q, s.v, options, dq, dv);
    for (std::size_t i = 0; i < dq.size(); ++i) {
      if (m->link(m->link_of_dof(static_cast<int>(i))).joint.type == JointType::spherical) continue;
      const double h = 1e-6;
      std::vector<double> v = s.v;
      v[i] += h;
      calc_joint_forces(*m, s.q, v, {}, options, high);
      v[i] -= 2 * h;
      calc_joint_forces(*m, s.q, v, {}, options, low);
      EXPECT_NEAR((high[i] - low[i]) / (2 * h), dv[i], 1e-4 * (1 + std::fabs(dv[i])));
      unit[i] = 1;
      integrate(*m, s.q, unit, h, q);
      calc_joint_forces(*m, q, s.v, {}, options, high);
      integrate(*m, s.q, unit, -h, q);
      calc_joint_forces(*m, q, s.v, {}, options, low);
      unit[i] = 0;
      EXPECT_NEAR((high[i] - low[i]) / (2 * h), dq[i], 1e-4 * (1 + std::fabs(dq[i]))) << "seed " << seed;
    }
  }
}

TEST(OpenSystem, JacobianIsTheSlopeOfItsAcceleration) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    MechanismSpec spec = sprung(seed, true)->spec();
    for (LinkSpec& l : spec.links)
      if (l.joint.type == JointType::spherical) l.joint.type = JointType::universal;  // the derivatives of spherical joints are approximate
    const MechanismPtr m = Mechanism::make(std::move(spec)).value();
    const State s = start_of(m, seed);
    OpenSystem system(m, {.joint_forces = {}, .exact_jacobian = true});
    system.drive = s.tau;
    const std::size_t n = s.v.size();
    std::vector<double> dq(n * n), dv(n * n), high(n), low(n), q(s.q.size()), unit(n);
    ASSERT_TRUE(system.calc_acceleration_jacobian(0, s.q, s.v, dq, dv));
    double scale = 1;
    for (const double x : dq) scale = std::max(scale, std::fabs(x));
    for (std::size_t j = 0; j < n; ++j) {
      const double h = 1e-6;
      const auto expect_column = [&](std::span<const double> expected, const char* label) {
        for (std::size_t i = 0; i < n; ++i)
          EXPECT_NEAR((high[i] - low[i]) / (2 * h), expected[i * n + j], 1e-5 * scale) << "seed " << seed << label << i << " " << j;
      };
      unit[j] = 1;
      integrate(*m, s.q, unit, h, q);
      ASSERT_EQ(system.calc_acceleration(0, q, s.v, high), -1);
      integrate(*m, s.q, unit, -h, q);
      ASSERT_EQ(system.calc_acceleration(0, q, s.v, low), -1);
      unit[j] = 0;
      expect_column(dq, " dq ");
      std::vector<double> v = s.v;
      v[j] += h;
      ASSERT_EQ(system.calc_acceleration(0, s.q, v, high), -1);
      v[j] -= 2 * h;
      ASSERT_EQ(system.calc_acceleration(0, s.q, v, low), -1);
      expect_column(dv, " dv ");
    }
  }
}

// A mass rebounds from a joint limit with the restitution of Hunt and Crossley: 1 - 2/3 c v for small c v, where c is the dissipation
// [s/m] and v the impact speed [m/s].
TEST(JointForces, LimitRestitutionMatchesHuntCrossley) {
  Dof f;
  f.upper = 0.5;
  for (const double dissipation : {0.0, 0.05}) {
    OpenSystem system(testing::sliders(1, f), {.gravity = {}, .joint_forces = {.limit_dissipation = dissipation}});
    Integrator integrator(system, adaptive(Method::dormand_prince_54, 1e-10));
    const double q[] = {0}, v[] = {1};
    integrator.start(0, q, v);
    ASSERT_EQ(integrator.advance(1).status, IntegrationStatus::reached);
    EXPECT_NEAR(integrator.v()[0], -(1 - 2.0 / 3 * dissipation), dissipation > 0 ? 2e-3 : 1e-8);
    EXPECT_LT(integrator.q()[0], 0.2);
  }
}

// A mass on a spring moves as x = rest + a cos(w t). Dry friction decelerates a mass by f / m until it creeps.
TEST(JointForces, SpringAndFrictionMatchClosedForm) {
  Dof spring;
  spring.stiffness = 40;
  spring.rest = 0.2;
  OpenSystem swinging(testing::sliders(1, spring), {.gravity = {}, .joint_forces = {}});
  Integrator a(swinging, adaptive(Method::dormand_prince_54, 1e-11));
  const double q[] = {0.7}, v[] = {0};
  a.start(0, q, v);
  ASSERT_EQ(a.advance(3).status, IntegrationStatus::reached);
  EXPECT_NEAR(a.q()[0], 0.2 + 0.5 * std::cos(std::sqrt(40.0) * 3), 1e-8);

  Dof rough;
  rough.friction = 2;
  OpenSystem braked(testing::sliders(1, rough), {.gravity = {}, .joint_forces = {.friction_speed = 1e-4}});
  Integrator b(braked, adaptive(Method::radau_iia_5, 1e-8));
  const double at[] = {0}, fast[] = {1};
  b.start(0, at, fast);
  ASSERT_EQ(b.advance(0.4).status, IntegrationStatus::reached);
  EXPECT_NEAR(b.v()[0], 1 - 2 * 0.4, 1e-4);
  ASSERT_EQ(b.advance(1).status, IntegrationStatus::reached);
  EXPECT_NEAR(b.v()[0], 0, 1e-6);
  EXPECT_NEAR(b.q()[0], 0.25, 1e-3);
}

// Seven joints of random types with springs and limits, without losses, conserve energy.
TEST(JointForces, SprungTreesKeepTheirEnergy) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const MechanismPtr m = sprung(seed, false);
    const State s = start_of(m, seed);
    OpenSystem system(m, {.joint_forces = {.limit_turn = 200, .limit_shift = 200, .limit_dissipation = 0}});
    Integrator integrator(system, adaptive(Method::dormand_prince_54, 1e-10));
    std::vector<double> v(s.v.size());
    integrator.start(0, s.q, v);
    const double before = system.calc_energy(s.q, v);
    ASSERT_EQ(integrator.advance(0.5).status, IntegrationStatus::reached);
    Workspace ws(*m);
    update_kinematics(*m, integrator.q(), integrator.v(), ws);
    const double scale = kinetic_energy(*m, ws) + std::fabs(before);
    EXPECT_NEAR(system.calc_energy(integrator.q(), integrator.v()), before, 1e-6 * scale) << "seed " << seed;
  }
}

}  // namespace
}  // namespace ugoki::dynamics
