// Integration of closed link systems: energy, gaps, loops closed and opened while running.

#include "ugoki/dynamics/closed_system.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "benchmark_mechanisms.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/dynamics/integrators.h"

namespace ugoki::dynamics {
namespace {

using testing::ClosedCase;

OpenSystemOptions options_of(const ClosedCase& c) {
  OpenSystemOptions o;
  o.gravity = c.gravity;
  o.joint_forces_on = false;
  return o;
}

struct Drift {
  double energy = 0;  ///< J
  double gap = 0;     ///< m | rad
  IntegrationStatus status = IntegrationStatus::reached;
};

/// Integrates for `seconds` and measures energy drift and gaps at `samples` times.
/// @param step s; 0: adaptive
Drift run(const ClosedCase& c, IntegrationMethod method, double step, double seconds, int samples) {
  ClosedSystem system(c.mechanism, options_of(c));
  std::vector<double> q = c.q, v = c.v;
  Drift drift;
  if (system.project(0, q, v) == Projection::failed) {
    drift.status = IntegrationStatus::projection_failed;
    return drift;
  }
  IntegratorOptions options;
  options.method = method;
  options.step = step;
  options.adaptive = step == 0;
  options.relative_tolerance = options.absolute_tolerance = 1e-11;
  Integrator integrator(system, options);
  integrator.start(0, q, v);
  const double energy = system.calc_energy(q, v);
  Workspace ws(*c.mechanism);
  LoopRows rows(c.mechanism->loops());
  for (int i = 1; i <= samples; ++i) {
    const IntegrationReport report = integrator.advance(seconds * i / samples);
    if (report.status != IntegrationStatus::reached) {
      drift.status = report.status;
      return drift;
    }
    drift.energy = std::max(drift.energy, std::fabs(system.calc_energy(integrator.q(), integrator.v()) - energy));
    update_kinematics(*c.mechanism, integrator.q(), integrator.v(), ws);
    update_loop_rows(*c.mechanism, ws, c.mechanism->loops(), integrator.q(), integrator.v(), rows);
    for (const double gap : rows.gap) drift.gap = std::max(drift.gap, std::fabs(gap));
  }
  return drift;
}

TEST(ClosedSystem, ConservativeFourBarKeepsItsEnergy) {
  const ClosedCase c = testing::four_bar({}, 0.4, 6);
  const Drift drift = run(c, IntegrationMethod::gauss_legendre_6, 1e-3, 10, 500);
  EXPECT_EQ(drift.status, IntegrationStatus::reached);
  EXPECT_LT(drift.energy, 1e-9);
  EXPECT_LT(drift.gap, 1e-12);
}

TEST(Slow_ClosedSystem, ConservativeFourBarKeepsItsEnergyForAMillionSteps) {
  const ClosedCase c = testing::four_bar({}, 0.4, 6);
  const Drift drift = run(c, IntegrationMethod::gauss_legendre_6, 1e-3, 1000, 10000);
  EXPECT_EQ(drift.status, IntegrationStatus::reached);
  EXPECT_LT(drift.energy, 1e-7);
  EXPECT_LT(drift.gap, 1e-12);
  RecordProperty("energy_drift_J", std::to_string(drift.energy * 1e9) + "e-9");
}

TEST(ClosedSystem, MassRatioOfAMillionKeepsLoopClosed) {
  testing::FourBar f;
  f.coupler_mass = 1e6;
  const Drift drift = run(testing::four_bar(f, 0.4, 1), IntegrationMethod::dormand_prince_54, 1e-3, 2, 200);
  EXPECT_EQ(drift.status, IntegrationStatus::reached);
  EXPECT_LT(drift.gap, 1e-9);
  testing::FourBar g;
  g.crank_mass = 1e6;
  g.rocker_mass = 1;
  g.coupler_mass = 1;
  const Drift other = run(testing::four_bar(g, 0.4, 1), IntegrationMethod::dormand_prince_54, 1e-3, 2, 200);
  EXPECT_EQ(other.status, IntegrationStatus::reached);
  EXPECT_LT(other.gap, 1e-9);
}

TEST(ClosedSystem, LaddersAndBricardKeepTheirEnergy) {
  for (const int n : {2, 40}) {
    const Drift drift = run(testing::n_four_bar(n), IntegrationMethod::dormand_prince_54, 1e-3, 1, 100);
    EXPECT_EQ(drift.status, IntegrationStatus::reached) << n;
    EXPECT_LT(drift.energy, 1e-6) << n;
    EXPECT_LT(drift.gap, 1e-11) << n;
  }
  const Drift drift = run(testing::bricard(), IntegrationMethod::dormand_prince_54, 1e-3, 1, 100);
  EXPECT_EQ(drift.status, IntegrationStatus::reached);
  EXPECT_LT(drift.energy, 1e-6);
  EXPECT_LT(drift.gap, 1e-11);
}

TEST(Slow_ClosedSystem, LaddersAndBricardKeepTheirEnergyForTenSeconds) {
  for (const int n : {2, 40}) {
    const Drift drift = run(testing::n_four_bar(n), IntegrationMethod::dormand_prince_54, 0, 10, 1000);
    EXPECT_EQ(drift.status, IntegrationStatus::reached) << n;
    EXPECT_LT(drift.energy, 1e-6) << n;
  }
  const Drift drift = run(testing::bricard(), IntegrationMethod::dormand_prince_54, 0, 10, 1000);
  EXPECT_EQ(drift.status, IntegrationStatus::reached);
  EXPECT_LT(drift.energy, 1e-6);
}

/// Momentum of the mechanism: linear [N s], and angular about the world's origin [N m s].
Vec6 momentum_of(const Mechanism& m, std::span<const double> q, std::span<const double> v) {
  Workspace ws(m);
  update_kinematics(m, q, v, ws);
  return momentum(m, ws);
}

TEST(ClosedSystem, GraspingARailLosesImpactEnergyAndReleasingLosesNone) {
  // Two links hang from a pin. The free end (the hand) grasps a rail while swinging, stays attached to it, and releases it.
  MechanismSpec spec;
  spec.name = "swinger";
  for (const char* name : {"upper", "lower"}) {
    LinkSpec l = testing::hinged(name, spec.links.empty() ? "" : "upper", spec.links.empty() ? 0 : 0.5, 0, testing::bar_inertia(2, 0.5));
    spec.links.push_back(l);
  }
  const MechanismPtr m = *Mechanism::make(std::move(spec));
  OpenSystemOptions system_options;
  system_options.gravity = testing::gravity_y;
  system_options.joint_forces_on = false;
  ClosedSystem system(m, system_options);
  IntegratorOptions options;
  options.method = IntegrationMethod::gauss_legendre_6;
  options.step = 1e-3;
  Integrator integrator(system, options);
  integrator.start(0, std::vector<double>{-1.2, 0.9}, std::vector<double>{3, -2});
  ASSERT_EQ(integrator.advance(0.3).status, IntegrationStatus::reached);
  std::vector<double> q(integrator.q().begin(), integrator.q().end()), v(integrator.v().begin(), integrator.v().end());
  const double swinging = system.calc_energy(q, v);

  // The rail is a line through the hand's position, across the plane of motion. A planar mechanism cannot slide along it, so it acts as a
  // pin.
  Workspace ws(*m);
  update_kinematics(*m, q, v, ws);
  const Pose X_WL = ws.X_WB[1];
  const Vec3 hand = X_WL * Vec3{0.5, 0, 0};
  Loop rail{.name = "rail", .type = LoopType::cylindrical, .link_a = -1, .link_b = 1};
  rail.axis = {0, 0, 1};
  rail.X_AJ = {Mat3::identity(), hand};
  rail.X_BJ = {Mat3::identity(), {0.5, 0, 0}};
  const Vec6 before = momentum_of(*m, q, v);
  const std::vector<double> v_before = v;
  const ClosingReport report = system.close(system.add_loop(rail), q, v);
  ASSERT_EQ(report.status, ClosedStatus::ok);
  EXPECT_LT(report.gap, 1e-14);
  EXPECT_GT(report.energy_lost, 0.01);

  // The lost energy is half the product of the impulse on the hand and the hand's velocity before the loop was closed.
  const double hanging = system.calc_energy(q, v);
  EXPECT_NEAR(swinging - hanging, report.energy_lost, 1e-10);
  update_kinematics(*m, q, v_before, ws);
  const Vec3 hand_speed = point_velocity(ws, 1, hand);
  Vec3 impulse;  // on the hand
  for (int r = 0; r < 4; ++r) {
    const auto k = static_cast<std::size_t>(r);
    impulse += system.links().rows().W[k].v * system.links().multipliers()[k];
  }
  EXPECT_NEAR(report.energy_lost, -0.5 * dot(impulse, hand_speed), 1e-10);
  // The pin exerts no moment, so the angular momentum about the pin changes by the moment of the hand's impulse.
  const Vec6 after = momentum_of(*m, q, v);
  EXPECT_NEAR(after.w.z - before.w.z, cross(hand, impulse).z, 1e-10);
  // Two links between two pins cannot move.
  for (const double speed : v) EXPECT_NEAR(speed, 0, 1e-12);

  integrator.start(0.3, q, v);
  ASSERT_EQ(integrator.advance(0.5).status, IntegrationStatus::reached);
  EXPECT_NEAR(system.calc_energy(integrator.q(), integrator.v()), hanging, 1e-10);
  q.assign(integrator.q().begin(), integrator.q().end());
  v.assign(integrator.v().begin(), integrator.v().end());
  system.open(0);
  EXPECT_NEAR(system.calc_energy(q, v), hanging, 1e-12) << "releasing does not change the energy";
  integrator.start(0.5, q, v);
  ASSERT_EQ(integrator.advance(1.5).status, IntegrationStatus::reached);
  EXPECT_NEAR(system.calc_energy(integrator.q(), integrator.v()), hanging, 1e-10);
  EXPECT_GT(norm(Vec3{integrator.v()[0], integrator.v()[1], 0}), 0.5) << "the links swing again after the release";
}

TEST(ClosedSystem, ClosingAFloatingChainConservesMomentum) {
  MechanismSpec spec;
  spec.name = "ring";
  for (int i = 0; i < 6; ++i) {
    LinkSpec l = testing::hinged("link" + std::to_string(i), i == 0 ? "" : "link" + std::to_string(i - 1), i == 0 ? 0 : 0.3, 0,
                                 testing::planar_inertia(1 + 0.2 * i, 0.15, 0.02, 0.01));
    if (i == 0) l.joint.type = JointType::floating;
    if (i % 2 == 1) l.joint.axis = normalized(Vec3{0.2, 0.3, 1});
    spec.links.push_back(l);
  }
  const MechanismPtr m = *Mechanism::make(std::move(spec));
  OpenSystemOptions system_options;
  system_options.gravity = {};
  system_options.joint_forces_on = false;
  ClosedSystem system(m, system_options);
  State s(*m);
  for (std::size_t i = 7; i < s.q.size(); ++i) s.q[i] = 1.0;
  for (std::size_t i = 0; i < s.v.size(); ++i) s.v[i] = std::sin(1.0 + static_cast<double>(i));
  Workspace ws(*m);
  update_kinematics(*m, s.q, s.v, ws);
  Loop grip{.name = "grip", .type = LoopType::ball, .link_a = 0, .link_b = 5};
  const Vec3 point = ws.X_WB[5] * Vec3{0.3, 0, 0};
  grip.X_BJ.p = {0.3, 0, 0};
  grip.X_AJ.p = ws.X_WB[0].inverse() * point;
  const Vec6 before = momentum_of(*m, s.q, s.v);
  const double energy = system.calc_energy(s.q, s.v);
  const ClosingReport report = system.close(system.add_loop(grip), s.q, s.v);
  ASSERT_EQ(report.status, ClosedStatus::ok);
  const Vec6 after = momentum_of(*m, s.q, s.v);
  EXPECT_LT(norm(after.w - before.w), 1e-10);
  EXPECT_LT(norm(after.v - before.v), 1e-10);
  EXPECT_NEAR(system.calc_energy(s.q, s.v), energy - report.energy_lost, 1e-10);
  IntegratorOptions options;
  options.method = IntegrationMethod::gauss_legendre_6;
  options.step = 2e-3;
  Integrator integrator(system, options);
  integrator.start(0, s.q, s.v);
  ASSERT_EQ(integrator.advance(2).status, IntegrationStatus::reached);
  const Vec6 later = momentum_of(*m, integrator.q(), integrator.v());
  EXPECT_LT(norm(later.w - before.w), 1e-8);
  EXPECT_LT(norm(later.v - before.v), 1e-8);
  EXPECT_NEAR(system.calc_energy(integrator.q(), integrator.v()), energy - report.energy_lost, 1e-7);
}

}  // namespace
}  // namespace ugoki::dynamics
