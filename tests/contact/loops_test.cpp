// Closed link systems among contacts.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "ugoki/collision/scene.h"
#include "ugoki/contact/stepper.h"
#include "ugoki/dynamics/closed_system.h"
#include "ugoki/dynamics/integrators.h"
#include "ugoki/mechanism/state.h"

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

/// Four bars, closed as a square where they are equal and q = (.., pi/2, pi/2, pi/2); the last pin is a loop, or a virtual link.
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

TEST(StepperLoops, AClosedChainMovesAsItsOwnDynamicsSay) {
  // Pinned at one corner, the bars unequal, so that its angles are not proportional; against the integrators' closed system at a
  // first-order distance.
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
    Simulation again(square(false, JointType::revolute, 0.5));
    again.state.q = q;
    const double dt = 1e-3 / refined;
    for (int i = 0; i < 300 * refined; ++i) {
      const StepReport report = again.step(dt, false);
      ASSERT_EQ(report.status, StepStatus::ok);
      ASSERT_LT(report.loop_gap, 1e-12);
    }
    double& worst = difference[refined == 1 ? 0 : 1];
    for (std::size_t i = 0; i < q.size(); ++i) worst = std::max(worst, std::fabs(again.state.q[i] - integrator.q()[i]));
  }
  EXPECT_LT(difference[0], 0.02);
  EXPECT_NEAR(difference[0] / difference[1], 4, 1) << "first order in the step";
}

TEST(StepperLoops, AFrameFallsAndComesToRest) {
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
    EXPECT_LT(speed, 0.05) << "it lies";
    EXPECT_FALSE(sim.contacts.empty());
    for (const collision::ContactPoint& c : sim.contacts) EXPECT_GT(c.distance, -2e-3);
    Vec3 force;
    for (const Vec3& f : sim.stepper.contact_forces()) force += f;
    EXPECT_NEAR(force.z, 9.81 * sim.m->mass(), 0.02 * 9.81 * sim.m->mass());
  }
}

TEST(StepperLoops, CoupledGearsTurnTogether) {
  // Two gears share the middle wheel. Their rows are constant, so that velocities hold as exactly as positions.
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
