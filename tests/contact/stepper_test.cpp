#include <gtest/gtest.h>

#include <cmath>

#include "../mechanism/chain.h"
#include "allocation_count.h"
#include "ugoki/base/hash.h"
#include "world.h"

namespace ugoki::contact {
namespace {

/// A chain of capsules on a floating base, like a falling ragdoll.
MechanismPtr rag(int links) {
  return testing::make_chain(links, [](int i, LinkSpec& l) {
    l.joint.type = i == 0 ? JointType::floating : i % 2 ? JointType::spherical : JointType::revolute;
    l.joint.axis = {0, 1, 0};
    if (i > 0) l.joint.X_PJ.p = {0.3, 0, 0};
    for (int k = 0; k < l.joint.nv() && i > 0; ++k) l.joint.dofs[static_cast<std::size_t>(k)] = {-1.0, 1.0, 0.5, 0, 0, 0, 0, 1e9};
    l.shapes.push_back(Shape::capsule(0.05, {0, 0, 0}, {0.3, 0, 0}));
    l.inertia = solid_inertia(l.shapes[0], 1000);
  });
}

TEST(Stepper, BoxComesToRestAndStays) {
  World w({body("box", Shape::box({0.2, 0.15, 0.1}), 500)}, {}, {});
  w.states[0].q[2] = 0.3;
  for (int i = 0; i < 1000; ++i) ASSERT_EQ(w.step(0.002).status, StepStatus::ok);
  const double x = w.states[0].q[0], z = w.states[0].q[2];
  EXPECT_NEAR(z, 0.1, 6e-4);
  for (int i = 0; i < 5000; ++i) ASSERT_EQ(w.step(0.002).status, StepStatus::ok);
  EXPECT_NEAR(w.states[0].q[0], x, 1e-5);
  EXPECT_NEAR(w.states[0].q[2], z, 5e-4);  // m: the box may sink by the compliance of the contact, not deeper
  EXPECT_GT(w.lowest(), -6e-4);
  Vec3 force;
  for (const Vec3& f : w.stepper.contact_forces()) force += f;
  EXPECT_NEAR(force.z, 9.81 * w.stepper.mechanism(0).mass(), 1e-3 * 9.81 * w.stepper.mechanism(0).mass());
}

// Tilted gravity acts as a slope: the box slides with g (sin - mu cos) if tan(angle) > mu, and stays otherwise.
TEST(Stepper, BoxOnSlopeObeysCoulombFriction) {
  Shape shape = Shape::box({0.2, 0.2, 0.1});
  shape.friction = 0.5;
  for (const double angle : {0.44, 0.49}) {
    StepperOptions options;
    options.gravity = {9.81 * std::sin(angle), 0, -9.81 * std::cos(angle)};
    World w({body("box", shape, 500)}, {0, 0.5, 0}, options);
    w.states[0].q[2] = 0.1;
    for (int i = 0; i < 500; ++i) ASSERT_EQ(w.step(0.002).status, StepStatus::ok);
    const double acceleration = 9.81 * (std::sin(angle) - 0.5 * std::cos(angle));
    if (std::tan(angle) < 0.5)
      EXPECT_LT(w.states[0].q[0], 2e-3);
    else
      EXPECT_NEAR(w.states[0].q[0], 0.5 * acceleration, 0.02 * acceleration);
  }
}

TEST(Stepper, ElasticBallsMatchClosedForm) {
  Shape ball = Shape::sphere(0.1);
  ball.restitution = 1;
  ball.friction = 0;
  StepperOptions options;
  options.gravity = {};
  World w({body("a", ball, 1000), body("b", ball, 3000)}, {-10, 0, 0}, options);
  w.states[0].q[0] = -0.5;
  w.states[0].v[3] = 2.0;
  for (int i = 0; i < 300; ++i) ASSERT_EQ(w.step(0.002).status, StepStatus::ok);
  // m2 = 3 m1: v1' = (m1 - m2)/(m1 + m2) v = -1, v2' = 2 m1/(m1 + m2) v = 1
  EXPECT_NEAR(w.states[0].v[3], -1.0, 1e-12);
  EXPECT_NEAR(w.states[1].v[3], 1.0, 1e-12);
  EXPECT_NEAR(w.states[0].v[3] + 3 * w.states[1].v[3], 2.0, 1e-12);
}

TEST(Stepper, BounceHeightScalesWithSquareOfRestitution) {
  Shape ball = Shape::sphere(0.1);
  ball.restitution = 0.8;
  World w({body("ball", ball, 300)}, {}, {});
  w.states[0].q[2] = 1.1;
  double highest = 0;
  bool bounced = false;
  for (int i = 0; i < 900; ++i) {
    ASSERT_EQ(w.step(0.001).status, StepStatus::ok);
    bounced = bounced || w.states[0].v[5] > 0;
    if (bounced) highest = std::max(highest, w.states[0].q[2]);
  }
  EXPECT_NEAR(highest - 0.1, 0.64, 0.02);
}

TEST(Stepper, FallingRagdollStaysBoundedAndComesToRest) {
  World w({rag(12)}, {}, {});
  w.states[0].q[2] = 1.0;
  for (int i = 0; i < w.stepper.mechanism(0).nv(); ++i) w.states[0].v[static_cast<std::size_t>(i)] = 0.3 * (i % 5 - 2);
  double worst = 0, fastest = 0;
  for (int i = 0; i < 4000; ++i) {
    ASSERT_EQ(w.step(0.002).status, StepStatus::ok);
    worst = std::min(worst, w.lowest());
    if (i > 3500)
      for (const double v : w.states[0].v) fastest = std::max(fastest, std::fabs(v));
  }
  EXPECT_GT(worst, -0.01);
  EXPECT_LT(fastest, 0.05);
  for (const Link& l : w.stepper.mechanism(0).links()) {
    if (l.joint.type != JointType::revolute) continue;
    EXPECT_LT(std::fabs(w.states[0].q[static_cast<std::size_t>(l.q_index)]), 1.02) << "limit of " << l.name;
  }
}

TEST(Stepper, JointLimitAndDryFrictionHoldTheLoad) {
  MechanismSpec spec;
  spec.name = "arm";
  LinkSpec l;
  l.name = "arm";
  l.joint.type = JointType::revolute;
  l.joint.axis = {0, 1, 0};
  l.joint.dofs[0].upper = 0.5;
  l.inertia = Inertia::from_centre(1, {0.5, 0, 0}, {0.01, 0.01, 0.01, 0, 0, 0});
  spec.links.push_back(l);
  World limited({Mechanism::make(spec).value()}, {-10, 0, 0}, {});
  for (int i = 0; i < 2000; ++i) ASSERT_EQ(limited.step(0.002).status, StepStatus::ok);
  EXPECT_NEAR(limited.states[0].q[0], 0.5, 2e-3);
  spec.links[0].joint.dofs[0] = {};
  spec.links[0].joint.dofs[0].friction = 5.0;  // N m; the weight produces 4.9 N m
  World rubbed({Mechanism::make(spec).value()}, {-10, 0, 0}, {});
  for (int i = 0; i < 1000; ++i) ASSERT_EQ(rubbed.step(0.002).status, StepStatus::ok);
  EXPECT_NEAR(rubbed.states[0].q[0], 0, 1e-6);
  spec.links[0].joint.dofs[0].friction = 3.0;  // N m: too little to hold the weight
  World sliding({Mechanism::make(spec).value()}, {-10, 0, 0}, {});
  for (int i = 0; i < 10; ++i) ASSERT_EQ(sliding.step(0.002).status, StepStatus::ok);
  const double vdot = (0.5 * 9.81 - 3.0) / (0.01 + 0.25);
  EXPECT_NEAR(sliding.states[0].v[0], 0.02 * vdot, 0.01 * 0.02 * vdot);
}

TEST(Stepper, StiffImplicitDamperIsStable) {
  MechanismSpec spec;
  spec.name = "door";
  LinkSpec l;
  l.name = "door";
  l.joint.type = JointType::revolute;
  l.joint.dofs[0].damping = 1e5;
  l.joint.dofs[0].stiffness = 1e6;
  l.inertia = Inertia::from_centre(1, {0.5, 0, 0}, {0.01, 0.01, 0.01, 0, 0, 0});
  spec.links.push_back(l);
  World w({Mechanism::make(spec).value()}, {-10, 0, 0}, {});
  w.states[0].q[0] = 1;
  for (int i = 0; i < 500; ++i) ASSERT_EQ(w.step(0.002).status, StepStatus::ok);
  EXPECT_NEAR(w.states[0].q[0], std::exp(-10.0), 1e-3);  // overdamped: the decay rate is k/d = 10 per second
}

TEST(Stepper, SteadyStepsDoNotAllocateAndAreBitwiseReproducible) {
  const auto run = [](bool count) {
    World w({rag(10), body("ball", Shape::sphere(0.1), 400)}, {}, {});
    w.states[0].q[2] = 0.5;
    w.states[1].q[0] = 0.5;
    w.states[1].q[2] = 1.5;
    for (int i = 0; i < 1500; ++i) EXPECT_EQ(w.step(0.002).status, StepStatus::ok);
    const long before = allocations_so_far();
    for (int i = 0; i < 200; ++i) EXPECT_EQ(w.step(0.002).status, StepStatus::ok);
    if (count) EXPECT_EQ(allocations_so_far(), before);
    Hash64 hash;
    for (const State& s : w.states) {
      hash.add(s.q);
      hash.add(s.v);
    }
    return hash.value();
  };
  EXPECT_EQ(run(true), run(false));
}

TEST(Stepper, NonFiniteForceKeepsTheLastGoodState) {
  World w({body("box", Shape::box({0.2, 0.2, 0.2}), 500)}, {}, {});
  w.states[0].q[2] = 1;
  ASSERT_EQ(w.step(0.002).status, StepStatus::ok);
  const std::vector<double> q = w.states[0].q, v = w.states[0].v;
  w.states[0].tau[4] = std::nan("");
  const StepReport report = w.step(0.002);
  EXPECT_EQ(report.status, StepStatus::not_finite);
  EXPECT_EQ(report.system, 0);
  EXPECT_GE(report.dof, 0);
  EXPECT_EQ(w.states[0].q, q);
  EXPECT_EQ(w.states[0].v, v);
}

}  // namespace
}  // namespace ugoki::contact
