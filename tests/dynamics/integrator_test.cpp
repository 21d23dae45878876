#include "ugoki/dynamics/integrators.h"

#include <gtest/gtest.h>

#include <cmath>

#include "random_mechanism.h"
#include "ugoki/base/hash.h"

namespace ugoki::dynamics {
namespace {

using testing::RandomSource;

constexpr Vec3 gravity{0, 0, -9.81};

MechanismPtr pendulum(double length) {
  MechanismSpec spec;
  spec.name = "pendulum";
  LinkSpec l;
  l.name = "rod";
  l.joint.type = JointType::revolute;
  l.joint.axis = {0, 1, 0};
  l.inertia = Inertia::from_centre(2.0, {0, 0, -length}, {});
  spec.links.push_back(l);
  return Mechanism::make(std::move(spec)).value();
}

/// Complete elliptic integral by the arithmetic-geometric mean: the period of a pendulum of any amplitude.
double pendulum_period(double length, double amplitude) {
  double a = 1, g = std::cos(amplitude / 2);
  for (int i = 0; i < 40; ++i) {
    const double mean = 0.5 * (a + g);
    g = std::sqrt(a * g);
    a = mean;
  }
  return 2 * pi * std::sqrt(length / 9.81) / a;
}

TEST(RungeKutta, PendulumKeepsItsPeriod) {
  const MechanismPtr m = pendulum(1.3);
  Workspace ws(*m);
  State s(*m);
  s.q[0] = 2.0;
  const double period = pendulum_period(1.3, 2.0);
  const int steps = 2000;
  for (int i = 0; i < steps; ++i) ASSERT_TRUE(step_rk4(*m, ws, s, gravity, period / steps));
  EXPECT_NEAR(s.q[0], 2.0, 1e-9);
  EXPECT_NEAR(s.v[0], 0.0, 1e-8);
}

TEST(RungeKutta, IsOfFourthOrderOnTheManifold) {
  RandomSource random(5);
  const JointType joints[] = {JointType::spherical, JointType::revolute, JointType::universal, JointType::planar};
  const MechanismPtr m = Mechanism::make(random_spec(random, 5, joints)).value();
  const auto run = [&](int steps) {
    Workspace ws(*m);
    State s(*m);
    RandomSource start(9);
    randomize(start, *m, s);
    for (double& t : s.tau) t = 0;
    for (Vec6& f : s.external) f = {};
    for (int i = 0; i < steps; ++i) EXPECT_TRUE(step_rk4(*m, ws, s, gravity, 0.2 / steps));
    return s;
  };
  const State fine = run(3200);
  const auto error = [&](const State& s) {
    std::vector<double> d(s.v.size());
    difference(*m, fine.q, s.q, d);
    double sum = 0;
    for (const double x : d) sum += x * x;
    return std::sqrt(sum);
  };
  const double coarse = error(run(100)), half = error(run(200));
  EXPECT_GT(coarse / half, 13.0) << coarse << " " << half;
  EXPECT_LT(coarse / half, 19.0);
}

TEST(SemiImplicitEuler, FreeFallKeepsMomentumAndConverges) {
  RandomSource random(21);
  const JointType joints[] = {JointType::spherical, JointType::revolute};
  const MechanismPtr m = Mechanism::make(random_spec(random, 8, joints)).value();
  const auto drift = [&](double dt) {
    Workspace ws(*m);
    State s(*m);
    RandomSource start(2);
    randomize(start, *m, s);
    for (double& t : s.tau) t = 0;
    for (Vec6& f : s.external) f = {};
    update_kinematics(*m, s.q, s.v, ws);
    const Vec6 before = momentum(*m, ws);
    for (int i = 0; i < static_cast<int>(0.2 / dt + 0.5); ++i) EXPECT_TRUE(step_semi_implicit(*m, ws, s, {}, dt));
    update_kinematics(*m, s.q, s.v, ws);
    const Vec6 change = momentum(*m, ws) - before;
    return norm(change.v) / norm(before.v) + norm(change.w) / norm(before.w);
  };
  const double coarse = drift(1e-3), fine = drift(1e-4);
  EXPECT_LT(fine, 1e-2);
  EXPECT_GT(coarse / fine, 5.0);  // first order: ten times
}

TEST(Steps, GiveTheSameBitsTwice) {
  const auto run = [] {
    RandomSource random(4);
    const MechanismPtr m = Mechanism::make(random_spec(random, 20)).value();
    Workspace ws(*m);
    State s(*m);
    randomize(random, *m, s);
    for (double& t : s.tau) t = 0;
    for (int i = 0; i < 100; ++i) {
      EXPECT_TRUE(step_semi_implicit(*m, ws, s, gravity, 1e-4));
      EXPECT_TRUE(step_rk4(*m, ws, s, gravity, 1e-4));
    }
    Hash64 hash;
    hash.add(s.q);
    hash.add(s.v);
    return hash.value();
  };
  EXPECT_EQ(run(), run());
}

}  // namespace
}  // namespace ugoki::dynamics
