// Closed link systems with known motions: published benchmarks, closed forms, energy and gaps over long runs, singular
// configurations.

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "closed_motion.h"

namespace ugoki::dynamics {
namespace {

using namespace ugoki::testing;

/// Values of a table in ../shared/data/benchmarks, row by row; empty if the file does not exist.
std::vector<std::vector<double>> read_curve(const std::string& name) {
  std::ifstream file(std::string(UGOKI_SHARED_DATA) + "/benchmarks/" + name);
  std::vector<std::vector<double>> rows;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with('#')) continue;
    std::ranges::replace(line, ',', ' ');
    std::istringstream in(line);
    rows.emplace_back();
    for (double x = 0; in >> x;) rows.back().push_back(x);
  }
  return rows;
}

// `q`, `v`, `a`: published solution of the IVP test set, computed with PSIDE at tolerance 1e-14. `extended_q`, `extended_v`: solution of
// the textbook's equations, integrated in extended precision with 60,000 steps of order 4. The published values equal the integrated values
// at a time 1e-12 s later.
TEST(ClosedBenchmark, AndrewsMechanismMatchesPublishedStateAt30Milliseconds) {
  const double q[7] = {15.81077119629904,   -15.75637105984298, 0.04082224013073101, 0.5244099658805304,
                       -0.5347301163226948, 1.048080741042263,  0.5347301163226948};
  const double v[7] = {1139.920302151208, -1424.379294994111, 11.03291221937134, 0.5735699284790808,
                       19.29337464421385, 0.3231791658026955, -19.29337464421385};
  const double a[7] = {-24631.76316945196, 51850.37701610329, 324102.5686413781, 16743.62929479361,
                       566749.3645176213,  9826.520791458422, -566749.3645176222};
  const double extended_q[7] = {15.810771195154,   -15.756371058412, 0.040822240119653, 0.52440996587995,
                                -0.53473011634207, 1.0480807410419,  0.53473011634207};
  const double extended_v[7] = {1139.9203022591, -1424.3792951775, 11.03291191061,  0.57356991482875,
                                19.293374105017, 0.32317914924985, -19.293374105017};
  const ClosedCase c = andrews();
  IntegratorOptions options;
  options.step = 1e-6;
  options.relative_tolerance = options.absolute_tolerance = 1e-13;
  ClosedMotion motion(c, options, [](const auto& at, const auto&, auto& tau) { Andrews::forces(at, tau); });
  const double start = motion.energy() + Andrews::spring_energy(c.q) - Andrews::drive * c.q[0];
  ASSERT_TRUE(motion.advance(0.03));
  for (int i = 0; i < 7; ++i) {  // tolerance: eight digits, or a time shift of 2e-12 s
    EXPECT_NEAR(motion.q(i), q[i], std::max(1e-9, 2e-12 * std::fabs(v[i]))) << i;
    EXPECT_NEAR(motion.v(i), v[i], std::max(1e-8 * std::fabs(v[i]), 2e-12 * std::fabs(a[i]))) << i;
    EXPECT_NEAR(motion.q(i), extended_q[i], 2e-11) << i;
    EXPECT_NEAR(motion.v(i), extended_v[i], 1e-9 * std::fabs(v[i])) << i;
  }
  const std::vector<double> end(motion.integrator.q().begin(), motion.integrator.q().end());
  EXPECT_NEAR(motion.energy() + Andrews::spring_energy(end) - Andrews::drive * end[0], start, 1e-10);
  EXPECT_LT(motion.gap(), 1e-15);
}

// The reference motion passes its change points, the horizontal configurations, 20 times in 10 s.
TEST(ClosedBenchmark, TwoFourBarsFollowTheReferenceCurve) {
  const auto curve = read_curve("A02_N2_B0.csv");
  if (curve.empty()) GTEST_SKIP() << "no ../shared/data/benchmarks";
  ClosedMotion motion(n_four_bar(2), 1e-3);
  for (const std::vector<double>& at : curve) {
    ASSERT_TRUE(motion.advance(at[0]));
    const double s = std::sin(motion.q(0)), c = std::cos(motion.q(0)), w = motion.v(0);
    EXPECT_NEAR(c, at[1], 1e-8) << at[0];
    EXPECT_NEAR(s, at[2], 1e-8) << at[0];
    EXPECT_NEAR(-s * w, at[3], 1e-7) << at[0];
    EXPECT_NEAR(c * w, at[4], 1e-7) << at[0];
  }
}

/// Angle and speed of the uprights of n_four_bar(n) after `duration`. The ladder moves as a pendulum with one angle, whose equation is
/// integrated here by Runge-Kutta steps of order 4.
std::pair<double, double> ladder_as_pendulum(int n, double angle, double speed, double duration) {
  const double inertia = (n + 1) / 3.0 + n, weight = 9.81 * ((n + 1) / 2.0 + n);
  const int steps = 200000;
  const double h = duration / steps;
  const auto a = [&](double x) { return -weight / inertia * std::cos(x); };
  for (int i = 0; i < steps; ++i) {
    const double k1 = speed, l1 = a(angle), k2 = speed + h / 2 * l1, l2 = a(angle + h / 2 * k1);
    const double k3 = speed + h / 2 * l2, l3 = a(angle + h / 2 * k2), k4 = speed + h * l3, l4 = a(angle + h * k3);
    angle += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    speed += h / 6 * (l1 + 2 * l2 + 2 * l3 + l4);
  }
  return {angle, speed};
}

// The motion starts exactly at the change point, where the rank of J is lower by 2, so that the loops permit three DOFs.
TEST(ClosedBenchmark, MotionStartedAtChangePointStaysOnItsBranch) {
  ClosedCase c = n_four_bar(2);
  for (std::size_t i = 0; i < c.q.size(); ++i) {
    c.q[i] = 0;
    c.v[i] *= 3;
  }
  ClosedMotion motion(c, 5e-4);
  const Drift drift(motion, 3, 60);
  ASSERT_TRUE(drift.reached);
  const auto [angle, speed] = ladder_as_pendulum(2, 0, -3, 3);
  EXPECT_NEAR(motion.q(0), angle, 1e-8);
  EXPECT_NEAR(motion.v(0), speed, 1e-8);
  EXPECT_LT(drift.energy, 1e-7);
  EXPECT_LT(drift.gap, 1e-14);
}

TEST(ClosedBenchmark, TenFourBarsKeepTheirEnergy) {
  ClosedMotion motion(n_four_bar(10), 1e-3);
  const Drift drift(motion, 2, 20);
  ASSERT_TRUE(drift.reached);
  EXPECT_LT(drift.energy, 1e-7);
  EXPECT_LT(drift.gap, 1e-13);
  EXPECT_NEAR(motion.q(0), ladder_as_pendulum(10, pi / 2, -1, 2).first, 1e-8);
}

TEST(SlowClosedBenchmark, FortyFourBarsKeepTheirEnergy) {
  ClosedMotion motion(n_four_bar(40), 1e-3);
  const Drift drift(motion, 10, 100);
  ASSERT_TRUE(drift.reached);
  EXPECT_LT(drift.energy, 1e-6);
  EXPECT_LT(drift.gap, 1e-12);
  EXPECT_NEAR(motion.q(0), ladder_as_pendulum(40, pi / 2, -1, 10).first, 1e-6);
  std::printf("forty four-bars: energy drift %.2e J, gap %.2e m\n", drift.energy, drift.gap);
}

// IFToMM A05, with explicit steps that are small because the springs are stiff. The reference curve has ten decimals.
void expect_governor_on_its_curve(std::size_t points) {
  auto curve = read_curve("A05_s.csv");
  if (curve.empty()) GTEST_SKIP() << "no ../shared/data/benchmarks";
  curve.resize(std::min(points, curve.size()));
  ClosedMotion motion(governor(), 5e-5, [](const auto& q, const auto& v, auto& tau) { Governor::forces(q, v, tau); });
  for (const std::vector<double>& at : curve) {
    ASSERT_TRUE(motion.advance(at[0]));
    EXPECT_NEAR(motion.q(1), at[1], 2e-10) << at[0];
    EXPECT_NEAR(motion.q(2), at[2], 2e-10) << at[0];
    EXPECT_NEAR(motion.v(0), at[3], 1e-9) << at[0];
  }
}
TEST(ClosedBenchmark, StiffGovernorFollowsTheReferenceCurve) { expect_governor_on_its_curve(31); }
TEST(SlowClosedBenchmark, StiffGovernorFollowsTheReferenceCurveTo10Seconds) { expect_governor_on_its_curve(1000); }

TEST(ClosedBenchmark, BricardsMechanismKeepsItsEnergy) {
  ClosedMotion motion(bricard(), 1e-3);
  const Drift drift(motion, 10, 100);
  ASSERT_TRUE(drift.reached);
  EXPECT_LT(drift.energy, 1e-6);
  EXPECT_LT(drift.gap, 1e-13);
  EXPECT_EQ(motion.system.closed.dofs(), 1);
  EXPECT_GT(std::fabs(motion.q(0)), 0.1);  // the mechanism moves
}

/// Integrates a rotating crank with heavy bars in steps of 1 ms, and expects no drift of energy and gaps.
void expect_long_run_without_drift(int steps) {
  ClosedMotion motion(four_bar({}, 0.5, 3), 1e-3);
  const Drift drift(motion, steps * 1e-3, 100);
  ASSERT_TRUE(drift.reached);
  EXPECT_LT(drift.energy, 1e-7);
  EXPECT_LT(drift.gap, 1e-12);
  std::printf("%d steps: energy drift %.2e J, gap %.2e m\n", steps, drift.energy, drift.gap);
}
TEST(ClosedBenchmark, AFourBarKeepsItsEnergyForTenThousandSteps) { expect_long_run_without_drift(10000); }
TEST(SlowClosedBenchmark, AFourBarKeepsItsEnergyForAMillionSteps) { expect_long_run_without_drift(1000000); }

TEST(ClosedBenchmark, MassRatioOfAMillionInOneLoopConservesEnergy) {
  for (const FourBar& bars : {FourBar{.crank_mass = 1e-3, .coupler_mass = 1e3, .rocker_mass = 1e-3},
                              FourBar{.crank_mass = 1e3, .coupler_mass = 1e-3, .rocker_mass = 1e3}}) {
    ClosedMotion motion(four_bar(bars, 0.5, 3), 1e-3);
    const double energy = std::fabs(motion.energy());
    const Drift drift(motion, 5, 50);
    ASSERT_TRUE(drift.reached);
    EXPECT_LT(drift.gap, 1e-14);
    EXPECT_LT(drift.energy / energy, 1e-9);
  }
}

/// Energy of the slider-crank with crank and rod of length r, as a function of the crank's angle and speed alone, J.
double equal_slider_crank_energy(double r, double angle, double speed) {
  const double s = std::sin(angle), c = std::cos(angle);
  const double inertia = r * r / 3 + 0.8 * (r * r * (2.25 * s * s + 0.25 * c * c) + r * r / 12) + 0.7 * 4 * r * r * s * s;
  return 0.5 * inertia * speed * speed + 9.81 * 0.5 * r * s * (1 + 0.8);
}

// The two branches of the motion cross where the slider is on the crank's axis. The crank's speed follows from the energy.
TEST(ClosedBenchmark, SliderCrankPassesItsChangePoints) {
  const double r = 0.5;
  for (const double start : {0.2, pi / 2, pi / 2 - 1e-9, pi / 2 - 1e-4}) {
    SCOPED_TRACE(start);
    ClosedCase c = slider_crank(r, r, 0.2, 8);
    c.q = {start, -2 * start, 2 * r * std::cos(start)};
    c.v = {8, -16, -2 * r * std::sin(start) * 8};
    ClosedMotion motion(c, 1e-3);
    const double energy = equal_slider_crank_energy(r, start, 8);
    EXPECT_NEAR(motion.energy(), energy, 1e-12 * energy);
    for (int k = 1; k <= 50; ++k) {
      ASSERT_TRUE(motion.advance(0.1 * k));
      EXPECT_NEAR(equal_slider_crank_energy(r, motion.q(0), motion.v(0)), energy, 1e-7 * energy);
      EXPECT_NEAR(motion.q(2), 2 * r * std::cos(motion.q(0)), 1e-9);
      EXPECT_LT(motion.gap(), 1e-13);
    }
    EXPECT_GT(motion.q(0), 20);  // the crank makes full turns
  }
}

// Crank and rod are in line. The slider cannot move the crank there, so the slider must not be the independent DOF (theta_G).
TEST(ClosedBenchmark, SliderCrankMovesThroughItsDeadPoint) {
  const double l = 1, r = 0.3;
  ClosedCase c = slider_crank(r, l, 0, 4, {});
  ClosedWorkspace cw(*c.mechanism);
  update_closed(*c.mechanism, c.q, c.v, cw);
  ASSERT_EQ(cw.dofs(), 1);
  EXPECT_NE(cw.theta_G()[0], 2);
  std::vector<double> tau{0, 0, 50}, vdot(3);
  ASSERT_TRUE(calc_closed_forward_dynamics_by_unit_vectors(*c.mechanism, cw, tau, {}, {}, vdot));
  EXPECT_NEAR(vdot[0], 0, 1e-10);                      // a push along the rod does not turn the crank
  EXPECT_NEAR(vdot[2], -r * 16 * (1 + r / l), 1e-10);  // textbook formula: r w^2 (1 + r / l)
  ClosedMotion motion(c, 1e-3);
  const Drift drift(motion, 5, 50);
  EXPECT_LT(drift.energy, 1e-9);
  EXPECT_LT(drift.gap, 1e-13);
}

// The motion does not depend on the choice of the independent DOFs theta_G. A new choice changes neither q nor v.
TEST(ClosedBenchmark, ChoiceOfThetaGDoesNotAffectMotion) {
  const ClosedCase c = four_bars_in_series(2);
  ClosedMotion kept(c, 1e-3);
  ClosedMotion changed(c, 1e-3);
  int choices = 0;
  for (int k = 1; k <= 250; ++k) {
    ASSERT_TRUE(kept.advance(1e-3 * k));
    // Every seven steps, exchange one independent DOF (theta_G) with a dependent one (theta_S)
    ClosedWorkspace& cw = changed.system.closed;
    if (k % 7 == 0 && cw.rank == 4) {
      const auto other = static_cast<std::size_t>(k) % 4;
      std::swap(cw.dof_order[4 + other % 2], cw.dof_order[other]);
      ++choices;
    }
    ASSERT_TRUE(changed.advance(1e-3 * k));
  }
  EXPECT_GT(choices, 30);
  for (int i = 0; i < 6; ++i) {
    EXPECT_NEAR(changed.q(i), kept.q(i), 1e-9) << i;
    EXPECT_NEAR(changed.v(i), kept.v(i), 1e-8) << i;
  }
}

}  // namespace
}  // namespace ugoki::dynamics
