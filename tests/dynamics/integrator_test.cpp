#include "ugoki/dynamics/integrators.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "elliptic.h"
#include "integrator_scenes.h"
#include "ugoki/base/hash.h"
#include "ugoki/dynamics/centroidal.h"
#include "ugoki/dynamics/dynamics.h"

namespace ugoki::dynamics {
namespace {

using testing::adaptive;
using testing::all_methods;
using testing::fixed;
using testing::RandomSource;
using Method = IntegrationMethod;
using Status = IntegrationStatus;

constexpr double g = 9.81;

double order_of(Method method) {
  switch (method) {
    case Method::semi_implicit_euler: return 1;
    case Method::runge_kutta_4: return 4;
    case Method::gauss_legendre_6: return 6;
    default: return 5;
  }
}

/// Angle [rad] at time t [s] of a pendulum of this length [m], released at rest from `amplitude` [rad] (Whittaker, Analytical dynamics,
/// section 44).
double pendulum_angle(double length, double amplitude, double t) {
  const double k = std::sin(amplitude / 2);
  return 2 * std::asin(k * testing::jacobi(testing::elliptic_K(k) + std::sqrt(g / length) * t, k).sn);
}

TEST(Integrators, ConvergeWithTheirOrderOnTheManifold) {
  RandomSource random(5);
  const JointType joints[] = {JointType::spherical, JointType::revolute, JointType::universal, JointType::planar};
  const MechanismPtr m = Mechanism::make(random_spec(random, 4, joints)).value();
  OpenSystem system(m);
  State s(*m);
  randomize(random, *m, s);
  const auto run = [&](const IntegratorOptions& options) {
    Integrator integrator(system, options);
    integrator.start(0, s.q, s.v);
    EXPECT_EQ(integrator.advance(0.1).status, Status::reached);
    return std::vector<double>(integrator.q().begin(), integrator.q().end());
  };
  const std::vector<double> exact = run(fixed(Method::gauss_legendre_6, 0.1 / 640));
  for (const Method method : all_methods) {
    const auto error = [&](int steps) {
      std::vector<double> d(s.v.size());
      difference(*m, exact, run(fixed(method, 0.1 / steps)), d);
      double sum = 0;
      for (const double x : d) sum += x * x;
      return std::sqrt(sum);
    };
    const int steps = method == Method::semi_implicit_euler ? 800 : method == Method::gauss_legendre_6 ? 12 : 20;
    const double coarse = error(steps), fine = error(2 * steps);
    const double order = std::log2(coarse / fine);
    EXPECT_NEAR(order, order_of(method), 0.35) << static_cast<int>(method) << ": " << coarse << " " << fine;
    RecordProperty("order" + std::to_string(static_cast<int>(method)), std::to_string(order));
  }
}

TEST(Integrators, PendulumFollowsEllipticFunctions) {
  const MechanismPtr m = testing::pendulum({1.3});
  OpenSystem system(m);
  const double start[] = {2.6}, rest[] = {0.0};
  const auto error = [&](const IntegratorOptions& options) {
    Integrator integrator(system, options);
    integrator.start(0, start, rest);
    double worst = 0;
    for (int i = 1; i <= 20; ++i) {
      EXPECT_EQ(integrator.advance(0.31 * i).status, Status::reached);
      EXPECT_EQ(integrator.time(), 0.31 * i);
      worst = std::max(worst, std::fabs(integrator.q()[0] - pendulum_angle(1.3, 2.6, 0.31 * i)));
    }
    return worst;
  };
  EXPECT_LT(error(fixed(Method::semi_implicit_euler, 1e-4)), 5e-3);
  EXPECT_LT(error(fixed(Method::runge_kutta_4, 1e-3)), 1e-9);
  EXPECT_LT(error(fixed(Method::gauss_legendre_6, 1e-3)), 1e-11);
  EXPECT_LT(error(adaptive(Method::dormand_prince_54, 1e-10)), 1e-8);
  EXPECT_LT(error(adaptive(Method::radau_iia_5, 1e-9)), 1e-6);
}

/// A single free rigid body.
MechanismPtr free_body() {
  MechanismSpec spec;
  spec.name = "handle";
  LinkSpec l;
  l.name = "body";
  l.joint.type = JointType::floating;
  l.inertia = Inertia::from_centre(1.0, {}, {1, 2, 2.8, 0, 0, 0});
  spec.links.push_back(l);
  return Mechanism::make(std::move(spec)).value();
}

// A body that rotates about its intermediate axis flips repeatedly (Dzhanibekov effect). Its angular velocity in body axes is known in
// elliptic functions (Landau, Lifshitz, Mechanics, section 37). Its angular momentum in the world is constant.
TEST(Integrators, FreeBodyRotationMatchesClosedForm) {
  const MechanismPtr m = free_body();
  OpenSystem system(m, {.gravity = {}, .joint_forces = {}});
  State s(*m);
  s.v = {0, -5, 0.05, 1, 2, 3};
  const double I1 = 1, I2 = 2, I3 = 2.8;
  const double twice_E = I2 * 25 + I3 * 0.0025, L2 = I2 * I2 * 25 + I3 * I3 * 0.0025;
  const double k = std::sqrt((I2 - I1) * (twice_E * I3 - L2) / ((I3 - I2) * (L2 - twice_E * I1)));
  const double rate = std::sqrt((I3 - I2) * (L2 - twice_E * I1) / (I1 * I2 * I3));
  const auto spin_at = [&](double t) {
    const testing::Jacobi j = testing::jacobi(rate * t - testing::elliptic_K(k), k);
    return Vec3{std::sqrt((twice_E * I3 - L2) / (I1 * (I3 - I1))) * j.cn, std::sqrt((twice_E * I3 - L2) / (I2 * (I3 - I2))) * j.sn,
                std::sqrt((L2 - twice_E * I1) / (I3 * (I3 - I1))) * j.dn};
  };
  const auto run = [&](const IntegratorOptions& options, double tolerance) {
    Integrator integrator(system, options);
    integrator.start(0, s.q, s.v);
    Workspace ws(*m);
    int turns = 0;
    double last = -1;
    for (int i = 1; i <= 100; ++i) {
      const double t = 0.1 * i;
      ASSERT_EQ(integrator.advance(t).status, Status::reached);
      const std::span<const double> v = integrator.v();
      EXPECT_LT(norm(Vec3{v[0], v[1], v[2]} - spin_at(t)), tolerance) << "t " << t;
      turns += v[1] * last < 0;
      last = v[1];
      update_kinematics(*m, integrator.q(), v, ws);
      const Vec6 h = calc_centroidal(*m, ws).momentum;
      EXPECT_LT(norm(h.w - Vec3{0, -10, 0.14}), 2 * tolerance) << "t " << t;
      EXPECT_LT(norm(h.v - Vec3{1, 2, 3}), 1e-12);
      EXPECT_NEAR(kinetic_energy(*m, ws), 0.5 * twice_E + 7, 40 * tolerance);
    }
    EXPECT_EQ(turns, 2);
  };
  run(adaptive(Method::dormand_prince_54, 1e-12), 1e-7);
  run(fixed(Method::gauss_legendre_6, 2e-3), 1e-8);
  run(fixed(Method::runge_kutta_4, 1e-3), 1e-5);
}

// Reference curve of the IFToMM library of benchmarks, problem A01: a mass on a massless rod, released from the horizontal.
TEST(Integrators, PlanarPendulumMatchesReferenceCurve) {
  std::ifstream file(UGOKI_SHARED_DATA "/benchmarks/A01_P1.csv");
  if (!file) GTEST_SKIP() << "no reference data at " UGOKI_SHARED_DATA;
  const MechanismPtr m = testing::pendulum({1.0});
  OpenSystem system(m);
  Integrator integrator(system, adaptive(Method::dormand_prince_54, 1e-12));
  const double start[] = {pi / 2}, rest[] = {0.0};
  integrator.start(0, start, rest);
  double worst = 0;
  int rows = 0;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#') continue;
    double t = 0, x = 0, y = 0;
    char comma = 0;
    std::istringstream(line) >> t >> comma >> x >> comma >> y;
    ASSERT_EQ(integrator.advance(t).status, Status::reached);
    const double angle = integrator.q()[0];
    worst = std::max({worst, std::fabs(std::sin(angle) - x), std::fabs(-std::cos(angle) - y)});
    ++rows;
  }
  EXPECT_GT(rows, 100);
  EXPECT_LT(worst, 1e-9);
  RecordProperty("worst", std::to_string(worst));
}

TEST(Integrators, DoublePendulumKeepsItsEnergy) {
  const MechanismPtr m = testing::pendulum({1, 0.7});
  OpenSystem system(m);
  const double start[] = {2.0, 1.0}, rest[] = {0, 0};
  const double before = system.calc_energy(start, rest);
  const auto drift = [&](Method method) {
    Integrator integrator(system, fixed(method, 1e-3));
    integrator.start(0, start, rest);
    EXPECT_EQ(integrator.advance(20).status, Status::reached);
    return std::fabs(system.calc_energy(integrator.q(), integrator.v()) - before) / std::fabs(before);
  };
  EXPECT_LT(drift(Method::gauss_legendre_6), 1e-12);
  EXPECT_LT(drift(Method::runge_kutta_4), 1e-6);
}

// One million steps of 1 ms; run with --gtest_filter=Slow*.
TEST(SlowIntegrators, DoublePendulumKeepsItsEnergyForAMillionSteps) {
  const MechanismPtr m = testing::pendulum({1, 0.7});
  OpenSystem system(m);
  const double start[] = {2.0, 1.0}, rest[] = {0, 0};
  const double before = system.calc_energy(start, rest);
  for (const Method method : {Method::gauss_legendre_6, Method::runge_kutta_4, Method::semi_implicit_euler}) {
    Integrator integrator(system, fixed(method, 1e-3));
    integrator.start(0, start, rest);
    double worst = 0;
    for (int i = 1; i <= 1000; ++i) {
      ASSERT_EQ(integrator.advance(i).status, Status::reached);
      worst = std::max(worst, std::fabs(system.calc_energy(integrator.q(), integrator.v()) - before) / std::fabs(before));
    }
    std::printf("method %d: maximum relative change of energy %.3g, %ld accelerations\n", static_cast<int>(method), worst,
                integrator.statistics().accelerations);
    if (method == Method::gauss_legendre_6) {
      EXPECT_LT(worst, 1e-10);
    }
  }
}

TEST(Integrators, TighterToleranceGivesSmallerError) {
  const MechanismPtr m = testing::pendulum({1.3});
  OpenSystem system(m);
  const double start[] = {2.6}, rest[] = {0.0};
  for (const Method method : {Method::dormand_prince_54, Method::radau_iia_5}) {
    double last = 1;
    long steps_at_first = 0, steps = 0;
    for (const double tolerance : {1e-4, 1e-6, 1e-8, 1e-10}) {
      IntegratorOptions options = adaptive(method, tolerance);
      options.max_steps = 5000;
      Integrator integrator(system, options);
      integrator.start(0, start, rest);
      ASSERT_EQ(integrator.advance(3).status, Status::reached);
      const double error = std::fabs(integrator.q()[0] - pendulum_angle(1.3, 2.6, 3));
      EXPECT_LT(error, 300 * tolerance);
      EXPECT_LT(error, 0.3 * last) << tolerance;
      EXPECT_LT(integrator.statistics().rejected, integrator.statistics().steps / 4 + 4);
      last = error;
      steps = integrator.statistics().steps;
      if (steps_at_first == 0) steps_at_first = steps;
    }
    // With an error estimate of order h^5, a tolerance 10^6 times smaller needs 10^(6/5) = 16 times the steps; a wrong estimate needs more
    EXPECT_LT(steps, 16 * steps_at_first);
  }
}

TEST(Integrators, ContinuousSolutionHasItsOrder) {
  const MechanismPtr m = free_body();
  OpenSystem system(m);
  State s(*m);
  s.v = {0.4, -2, 1.0, 1, 2, 3};
  for (const Method method : all_methods) {
    const auto error = [&](double h) {
      Integrator integrator(system, fixed(method, h)), exact(system, fixed(Method::gauss_legendre_6, h / 10));
      integrator.start(0, s.q, s.v);
      exact.start(0, s.q, s.v);
      EXPECT_EQ(integrator.advance(h).status, Status::reached);
      EXPECT_EQ(exact.advance(0.3 * h).status, Status::reached);
      std::vector<double> q(s.q.size()), v(s.v.size()), d(s.v.size());
      integrator.interpolate(0.3 * h, q, v);
      difference(*m, exact.q(), q, d);
      double sum = 0;
      for (std::size_t i = 0; i < d.size(); ++i) sum += d[i] * d[i] + (v[i] - exact.v()[i]) * (v[i] - exact.v()[i]);
      integrator.interpolate(h, q, v);
      difference(*m, integrator.q(), q, d);
      for (const double x : d) EXPECT_NEAR(x, 0, 1e-13);
      return std::sqrt(sum);
    };
    const double order = std::log2(error(0.1) / error(0.05));
    const double expected_order = method == Method::semi_implicit_euler ? 2 : method == Method::dormand_prince_54 ? 5 : 4;
    EXPECT_GT(order, expected_order - 0.35) << static_cast<int>(method);
  }
}

TEST(Integrators, ResultsAreBitIdenticalForAnySplitOfTheTime) {
  const auto run = [](Method method, int pieces) {
    RandomSource random(4);
    const MechanismPtr m = Mechanism::make(random_spec(random, 12)).value();
    OpenSystem system(m);
    State s(*m);
    randomize(random, *m, s);
    Integrator integrator(system, fixed(method, 1.0 / 1024));
    integrator.start(0, s.q, s.v);
    for (int i = 1; i <= pieces; ++i) EXPECT_EQ(integrator.advance(i / (16.0 * pieces)).status, Status::reached);
    Hash64 hash;
    hash.add(integrator.q());
    hash.add(integrator.v());
    return hash.value();
  };
  for (const Method method : all_methods) EXPECT_EQ(run(method, 1), run(method, 8)) << static_cast<int>(method);
}

}  // namespace
}  // namespace ugoki::dynamics
