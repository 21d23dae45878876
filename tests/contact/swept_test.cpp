// Fast thin things do not get past each other, and bounce as their restitution says.

#include <gtest/gtest.h>

#include <cmath>

#include "ugoki/contact/swept_contacts.h"
#include "world.h"

namespace ugoki::contact {
namespace {

StepReport swept_step(World& w, SweptContacts& swept, double dt) {
  std::vector<collision::SystemMotion> motions;
  for (std::size_t i = 0; i < w.states.size(); ++i) {
    calc_poses(w.stepper.mechanism(static_cast<int>(i)), w.states[i].q, w.poses[i]);
    motions.push_back({w.states[i].q, w.states[i].v});
  }
  collision::find_contacts(w.scene, w.spans, 0.02, w.workspace, w.contacts);
  swept.add(motions, w.spans, dt, 0.02, w.contacts);
  return w.stepper.step(w.systems, w.contacts, dt);
}

/// A fixed plate 5 mm thick at x = 0, 1 m wide.
MechanismPtr plate() {
  MechanismSpec spec;
  spec.name = "plate";
  LinkSpec l;
  l.name = "plate";
  l.shapes.push_back(Shape::box({0.0025, 0.5, 0.5}));
  spec.links.push_back(l);
  return Mechanism::make(std::move(spec)).value();
}

TEST(Swept, ABallOf300MetresASecondDoesNotPassAPlateOf5Millimetres) {
  for (const double dt : {0.002, 0.001}) {
    for (const double e : {0.0, 0.5, 1.0}) {
      for (int i = 0; i < 20; ++i) {
        Shape shape = Shape::sphere(0.02);
        shape.restitution = e;
        shape.friction = 0;
        StepperOptions options;
        options.gravity = {};
        World w({body("ball", shape, 1000), plate()}, {-100, 0, 0}, options);
        SweptContacts swept(w.scene);
        w.states[0].q[0] = -1.5 - 0.031 * i;
        w.states[0].q[1] = -0.2;
        w.states[0].v[3] = 300;
        w.states[0].v[4] = 20;
        for (int k = 0; k < 40; ++k) {
          ASSERT_EQ(swept_step(w, swept, dt).status, StepStatus::ok);
          ASSERT_LT(w.states[0].q[0], -0.0225 + 1e-4) << "dt " << dt << " e " << e << " start " << i;
        }
        EXPECT_NEAR(w.states[0].v[3], -300 * e, e > 0 ? 3e-7 : 0.02) << "the softness is pushed out again";
        EXPECT_NEAR(w.states[0].v[4], 20, 1e-9);
      }
    }
  }
}

TEST(Swept, WhatFliesPastAPlateIsNotStopped) {
  StepperOptions options;
  options.gravity = {};
  World w({body("ball", Shape::sphere(0.02), 1000), plate()}, {-100, 0, 0}, options);
  SweptContacts swept(w.scene);
  w.states[0].q[0] = -1.5;
  w.states[0].q[1] = 0.53;
  w.states[0].v[3] = 300;
  for (int k = 0; k < 10; ++k) ASSERT_EQ(swept_step(w, swept, 0.002).status, StepStatus::ok);
  EXPECT_NEAR(w.states[0].q[0], -1.5 + 6, 1e-9);
}

TEST(Swept, TwoFastBallsMeetAsInTheClosedForm) {
  Shape shape = Shape::sphere(0.05);
  shape.restitution = 1;
  shape.friction = 0;
  StepperOptions options;
  options.gravity = {};
  World w({body("a", shape, 1000), body("b", shape, 1000), body("c", shape, 1000)}, {-100, 0, 0}, options);
  SweptContacts swept(w.scene);
  put(w.states[0], {-2, 0, 0});
  put(w.states[1], {2.1, 0, 0});
  put(w.states[2], {0, 5, 0});
  w.states[0].v[3] = 250;
  w.states[1].v[3] = -100;
  w.states[2].v[5] = -400;  // into the ground far below: at z = -100
  for (int k = 0; k < 200; ++k) ASSERT_EQ(swept_step(w, swept, 0.002).status, StepStatus::ok);
  EXPECT_NEAR(w.states[0].v[3], -100, 1e-9);
  EXPECT_NEAR(w.states[1].v[3], 250, 1e-9);
  EXPECT_NEAR(w.states[2].v[5], 400, 1e-9);
}

}  // namespace
}  // namespace ugoki::contact
