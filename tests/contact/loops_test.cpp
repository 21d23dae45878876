// Closed link systems in the stepper, with and without contacts.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "../dynamics/random_loops.h"
#include "ugoki/collision/scene.h"
#include "ugoki/contact/stepper.h"
#include "ugoki/dynamics/closed_system.h"
#include "ugoki/dynamics/integrators.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/spatial/rotation.h"

namespace ugoki::contact {
namespace {

LinkSpec bar(const std::string& name, const std::string& parent, const Vec3& at, double length) {
  LinkSpec l;
  l.name = name;
  l.parent = parent;
  l.joint.type = JointType::revolute;
  l.joint.axis = {0, 1, 0};
  l.joint.X_PJ.p = at;
  const Shape shape = Shape::capsule(0.03, {0, 0, 0}, {length, 0, 0});
  l.inertia = solid_inertia(shape, 1000);
  l.shapes.push_back(shape);
  return l;
}

/// Four bars in a ring. With equal lengths and q = (.., pi/2, pi/2, pi/2) they form a closed square. The last pin is modelled as a loop or
/// as a virtual link.
/// @param third m: length of the third bar
MechanismSpec square(bool virtual_link, JointType base, double third = 0.4) {
  MechanismSpec spec;
  spec.name = "square";
  spec.links = {bar("a", "", {0, 0, 0}, 0.4), bar("b", "a", {0.4, 0, 0}, 0.4), bar("c", "b", {0.4, 0, 0}, third),
                bar("d", "c", {third, 0, 0}, 0.4)};
  spec.links[0].joint.type = base;
  if (virtual_link) {
    spec.links.push_back(bar("a again", "d", {0.4, 0, 0}, 0.4));
    spec.links.back().inertia = {};
    spec.links.back().shapes.clear();
    spec.links.back().real = "a";
  } else {
    spec.loops.push_back({.name = "pin",
                          .type = LoopType::revolute,
                          .link_a = "a",
                          .link_b = "d",
                          .X_BJ = {Mat3::identity(), {0.4, 0, 0}},
                          .axis = {0, 1, 0}});
  }
  return spec;
}

struct Simulation {
  MechanismPtr m;
  collision::Scene scene;
  collision::Workspace workspace;
  Stepper stepper;
  State state;
  std::vector<Pose> poses;
  std::vector<collision::ContactPoint> contacts;

  explicit Simulation(MechanismSpec spec)
      : m(Mechanism::make(std::move(spec)).value()),
        scene({m}, {}),
        workspace(scene),
        stepper({m}, {}),
        state(*m),
        poses(static_cast<std::size_t>(m->link_count())) {
    const std::size_t first = m->link(0).joint.nv() == 6 ? 7 : 1;
    for (std::size_t i = first; i < state.q.size(); ++i) state.q[i] = pi / 2;
  }
  StepReport step(double dt, bool ground = true) {
    calc_poses(*m, state.q, poses);
    const std::span<const Pose> all[] = {poses};
    collision::find_contacts(scene, all, 0.02, workspace, contacts);
    if (!ground) contacts.clear();
    StepSystem system{state.q, state.v, state.tau, state.external, {}, {}};
    return stepper.step(std::span(&system, 1), contacts, dt);
  }
  static constexpr double pi = 3.14159265358979323846;
};

TEST(StepperLoops, ClosedChainMatchesClosedDynamics) {
  // The ring is pinned at one corner. Its bars have unequal lengths, so that the joint angles are not proportional to each other. The
  // difference from the integrators' solution of the closed system must be of first order in the step.
  Simulation sim(square(false, JointType::revolute, 0.5));
  sim.state.q[0] = 0.6;
  dynamics::OpenSystemOptions options;
  options.joint_forces_on = false;
  dynamics::ClosedSystem system(sim.m, options);
  std::vector<double> q = sim.state.q, v(q.size());
  ASSERT_NE(system.project(0, q, v), dynamics::Projection::failed);
  sim.state.q = q;
  dynamics::Integrator integrator(system, {});
  integrator.start(0, q, v);
  ASSERT_EQ(integrator.advance(0.3).status, dynamics::IntegrationStatus::reached);
  double difference[2] = {};
  for (const int refined : {1, 4}) {
    Simulation stepped(square(false, JointType::revolute, 0.5));
    stepped.state.q = q;
    const double dt = 5e-4 / refined;  // slow enough that no joint turns by more than InertialMotion::threshold
    for (int i = 0; i < 600 * refined; ++i) {
      const StepReport report = stepped.step(dt, false);
      ASSERT_EQ(report.status, StepStatus::ok);
      ASSERT_LT(report.loop_gap, 1e-12);
    }
    double& worst = difference[refined == 1 ? 0 : 1];
    for (std::size_t i = 0; i < q.size(); ++i) worst = std::max(worst, std::fabs(stepped.state.q[i] - integrator.q()[i]));
  }
  EXPECT_LT(difference[0], 0.02);
  EXPECT_GT(difference[0] / difference[1], 3) << "the error should be of first order in the step";
}

TEST(StepperLoops, RandomClosedMechanismsMatchClosedDynamicsToFirstOrder) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    const testing::RandomLoops closed(seed);
    testing::RandomSource same(seed), random(seed + 1000);
    MechanismSpec spec = testing::random_spec(same, 12);
    for (int k = 0; k < 3; ++k) {
      const Loop& l = closed.loops[static_cast<std::size_t>(random.below(static_cast<int>(closed.loops.size())))];
      if (l.type == LoopType::gear) continue;
      spec.loops.push_back({.name = "loop " + std::to_string(k),
                            .type = l.type,
                            .link_a = l.link_a < 0 ? "" : spec.links[static_cast<std::size_t>(l.link_a)].name,
                            .link_b = spec.links[static_cast<std::size_t>(l.link_b)].name,
                            .X_AJ = l.X_AJ,
                            .X_BJ = l.X_BJ,
                            .axis = l.axis,
                            .axis2 = l.axis2,
                            .length = l.length});
    }
    if (spec.loops.empty()) continue;
    Simulation coarse(spec), fine(spec);
    dynamics::OpenSystemOptions options;
    options.joint_forces_on = false;
    dynamics::ClosedSystem system(coarse.m, options);
    State start = closed.state;
    for (double& x : start.v) x *= 0.3;
    std::ranges::fill(start.tau, 0.0);
    ASSERT_NE(system.project(0, start.q, start.v), dynamics::Projection::failed) << seed;
    dynamics::Integrator integrator(system, {});
    integrator.start(0, start.q, start.v);
    ASSERT_EQ(integrator.advance(0.01).status, dynamics::IntegrationStatus::reached) << seed;
    const auto off = [&](Simulation& sim, int steps) {  // m/s | rad/s
      sim.state.q = start.q;
      sim.state.v = start.v;
      for (int i = 0; i < steps; ++i) EXPECT_EQ(sim.step(0.01 / steps, false).status, StepStatus::ok) << seed;
      double worst = 0;
      for (std::size_t i = 0; i < start.v.size(); ++i) worst = std::max(worst, std::fabs(sim.state.v[i] - integrator.v()[i]));
      return worst;
    };
    const double far = off(coarse, 100), near = off(fine, 400);
    EXPECT_LT(far, 0.5) << seed;
    EXPECT_NEAR(far / near, 4, 0.8) << seed;
  }
}

TEST(StepperLoops, ClosedFrameFallsAndComesToRest) {
  for (const bool virtual_link : {false, true}) {
    Simulation sim(square(virtual_link, JointType::floating));
    sim.state.q[2] = 0.8;
    double gap = 0;
    for (int i = 0; i < 2000; ++i) {
      const StepReport report = sim.step(2e-3);
      ASSERT_EQ(report.status, StepStatus::ok) << i;
      gap = std::max(gap, report.loop_gap);
    }
    EXPECT_LT(gap, 1e-12);
    double speed = 0;
    for (const double x : sim.state.v) speed = std::max(speed, std::fabs(x));
    EXPECT_LT(speed, 0.05) << "the frame should be at rest";
    EXPECT_FALSE(sim.contacts.empty());
    for (const collision::ContactPoint& c : sim.contacts) EXPECT_GT(c.distance, -2e-3);
    Vec3 force;
    for (const Vec3& f : sim.stepper.contact_forces()) force += f;
    EXPECT_NEAR(force.z, 9.81 * sim.m->mass(), 0.02 * 9.81 * sim.m->mass());
  }
}

/// A door on an oblique hinge axis. An optional loop is a second hinge on the same axis. This loop is redundant: its
/// constraint rows are zero except for rounding errors.
MechanismSpec door(std::optional<LoopType> second) {
  MechanismSpec spec;
  spec.name = "door";
  const Mat3 turned = rotation_about(normalized(Vec3{0.3, -0.5, 0.7}), 0.9);
  LinkSpec l = bar("leaf", "", {0.31, -0.27, 1.3}, 0.8);
  l.joint.X_PJ.R = turned;
  l.joint.axis = normalized(Vec3{0.2, 0.9, -0.4});
  const Vec3 up = l.joint.axis * 0.77;
  if (second)
    spec.loops.push_back({.name = "hinge",
                          .type = *second,
                          .link_b = "leaf",
                          .X_AJ = {turned, l.joint.X_PJ.p + turned * up},
                          .X_BJ = {Mat3::identity(), up},
                          .axis = l.joint.axis});
  spec.links = {l};
  return spec;
}

TEST(StepperLoops, OpenRingClosesAtBoundedSpeed) {
  Simulation sim(square(false, JointType::revolute, 0.5));
  sim.state.q = {0.6, 1.2, 1.9, 1.3};
  double gap = 1, fastest = 0;
  for (int i = 0; i < 50; ++i) {
    const StepReport report = sim.step(1e-3, false);
    ASSERT_EQ(report.status, StepStatus::ok);
    gap = report.loop_gap;
    for (const double x : sim.state.v) fastest = std::max(fastest, std::fabs(x));
  }
  EXPECT_LT(gap, 1e-12);
  EXPECT_LT(fastest, 6) << "rad/s";
}

TEST(StepperLoops, RedundantHingeHasNoEffect) {
  for (const LoopType type : {LoopType::ball, LoopType::revolute, LoopType::cylindrical}) {
    Simulation with(door(type)), without(door({}));
    with.state.q[0] = without.state.q[0] = 0.8;
    for (int i = 0; i < 1000; ++i) {
      ASSERT_EQ(with.step(2e-3, false).status, StepStatus::ok) << i;
      ASSERT_EQ(without.step(2e-3, false).status, StepStatus::ok);
      ASSERT_NEAR(with.state.q[0], without.state.q[0], 1e-9) << i << " type " << static_cast<int>(type);
    }
    EXPECT_GT(std::fabs(with.state.q[0] - 0.8), 0.3) << "the door should swing";
  }
}

TEST(StepperLoops, LoopsThatDuplicateJointsHaveNoEffect) {
  for (unsigned seed = 1; seed <= 500; ++seed) {
    testing::RandomSource random(seed);
    const double away = std::pow(10.0, random.below(4));
    const testing::DoubledJoints joints(random, random.below(2) == 0, away);
    Simulation with(joints.doubled), without(joints.tree);
    testing::randomize(random, *with.m, with.state);
    without.state = with.state;
    const State before = with.state;
    dynamics::OpenSystemOptions options;
    options.joint_forces_on = false;
    dynamics::ClosedSystem closed(with.m, options);
    dynamics::OpenSystem open(without.m, options);
    std::vector<double> a(before.v.size()), b(before.v.size());
    ASSERT_EQ(closed.calc_acceleration(0, before.q, before.v, a), -1) << seed;
    ASSERT_EQ(open.calc_acceleration(0, before.q, before.v, b), -1) << seed;
    double maximum = 1;  // m/s^2 | rad/s^2
    for (const double x : b) maximum = std::max(maximum, std::fabs(x));
    for (std::size_t i = 0; i < a.size(); ++i)
      ASSERT_NEAR(a[i], b[i], 1e-9 * maximum * away) << "seed " << seed << " degree of freedom " << i;

    // Short steps: fast open and closed systems are moved by different methods (InertialMotion).
    ASSERT_EQ(with.step(1e-4, false).status, StepStatus::ok) << seed;
    ASSERT_EQ(without.step(1e-4, false).status, StepStatus::ok) << seed;
    double change = 1;  // m/s | rad/s
    for (std::size_t i = 0; i < before.v.size(); ++i) change = std::max(change, std::fabs(without.state.v[i] - before.v[i]));
    for (std::size_t i = 0; i < before.v.size(); ++i)
      ASSERT_NEAR(with.state.v[i], without.state.v[i], 1e-9 * change * away) << "seed " << seed << " degree of freedom " << i;
  }
}

TEST(StepperLoops, LoopsOfVeryDifferentScaleStayClosedInOneMechanism) {
  // One mechanism has two closed squares of bars; one is a hundred thousand times larger than the other. Each must move as it does alone.
  const auto scaled = [](double size, const std::string& name) {
    MechanismSpec spec = square(false, JointType::revolute, 0.5);
    for (LinkSpec& l : spec.links) {
      l.name = name + l.name;
      if (!l.parent.empty()) l.parent = name + l.parent;
      l.joint.X_PJ.p = l.joint.X_PJ.p * size;
      const double m = size * size * size;
      l.inertia = {l.inertia.mass * m, l.inertia.h * (m * size), l.inertia.I * (m * size * size)};
      l.shapes.clear();
    }
    for (LoopSpec& l : spec.loops) {
      l.link_a = name + l.link_a;
      l.link_b = name + l.link_b;
      l.X_BJ.p = l.X_BJ.p * size;
    }
    return spec;
  };
  MechanismSpec both = scaled(1e-4, "watch ");
  const MechanismSpec crane = scaled(10, "crane ");
  both.links.insert(both.links.end(), crane.links.begin(), crane.links.end());
  both.loops.insert(both.loops.end(), crane.loops.begin(), crane.loops.end());
  both.loops[1].name = "second pin";
  Simulation together(both), watch(scaled(1e-4, "watch ")), large(crane);
  together.state.q[0] = together.state.q[4] = watch.state.q[0] = large.state.q[0] = 0.6;
  for (Simulation* s : {&together, &watch, &large})
    ASSERT_NE(dynamics::ClosedSystem(s->m, {}).project(0, s->state.q, s->state.v), dynamics::Projection::failed);
  for (Simulation* s : {&together, &watch, &large}) ASSERT_EQ(s->step(1e-4, false).status, StepStatus::ok);
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_NEAR(together.state.v[k], watch.state.v[k], 1e-3 * std::fabs(watch.state.v[0])) << "watch";
    EXPECT_NEAR(together.state.v[4 + k], large.state.v[k], 1e-3 * std::fabs(large.state.v[0])) << "crane";
  }
  for (int i = 0; i < 200; ++i) {
    const StepReport report = together.step(1e-4, false);
    ASSERT_EQ(report.status, StepStatus::ok) << i;
    ASSERT_LT(report.loop_gap, 1e-9) << i;
  }
  std::copy_n(together.state.q.begin(), 4, watch.state.q.begin());
  std::copy_n(together.state.v.begin(), 4, watch.state.v.begin());
  std::copy_n(together.state.q.begin() + 4, 4, large.state.q.begin());
  std::copy_n(together.state.v.begin() + 4, 4, large.state.v.begin());
  const auto accelerations = [](const Simulation& s) {
    dynamics::OpenSystemOptions options;
    options.joint_forces_on = false;
    dynamics::ClosedSystem system(s.m, options);
    std::vector<double> a(s.state.v.size());
    EXPECT_EQ(system.calc_acceleration(0, s.state.q, s.state.v, a), -1);
    return a;
  };
  const std::vector<double> a = accelerations(together), of_watch = accelerations(watch), of_crane = accelerations(large);
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_NEAR(a[k], of_watch[k], 1e-6 * (1 + std::fabs(of_watch[k])));
    EXPECT_NEAR(a[4 + k], of_crane[k], 1e-6 * (1 + std::fabs(of_crane[k])));
  }
}

TEST(StepperLoops, CoupledGearsTurnTogether) {
  // Two gears share the middle wheel b. The constraint rows of linear gears do not depend on the positions, so positions and velocities
  // both satisfy the gear ratios to rounding error.
  MechanismSpec spec;
  spec.name = "gears";
  spec.links = {bar("a", "", {0, 0, 0}, 0.4), bar("b", "", {1, 0, 0}, 0.2), bar("c", "", {2, 0, 0}, 0.3)};
  spec.loops.push_back({.name = "teeth", .type = LoopType::gear, .link_a = "a", .link_b = "b", .polynomial = {0, -2, 0, 0, 0}});
  spec.loops.push_back({.name = "more teeth", .type = LoopType::gear, .link_a = "c", .link_b = "b", .polynomial = {0, 0.5, 0, 0, 0}});
  Simulation sim(std::move(spec));
  sim.state.q = {0, 0, 0};
  for (int i = 0; i < 500; ++i) {
    ASSERT_EQ(sim.step(1e-3, false).status, StepStatus::ok);
    ASSERT_NEAR(sim.state.q[0], -2 * sim.state.q[1], 1e-12);
    ASSERT_NEAR(sim.state.q[2], 0.5 * sim.state.q[1], 1e-12);
    ASSERT_NEAR(sim.state.v[0], -2 * sim.state.v[1], 1e-9);
    ASSERT_NEAR(sim.state.v[2], 0.5 * sim.state.v[1], 1e-9);
  }
  EXPECT_GT(std::fabs(sim.state.q[0]), 0.05);
}

}  // namespace
}  // namespace ugoki::contact
