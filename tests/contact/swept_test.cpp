// Fast thin bodies do not pass through each other, and they bounce with their coefficient of restitution.

#include <gtest/gtest.h>

#include <cmath>

#include "ugoki/contact/guarded_step.h"
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

TEST(Swept, BallAt300MetresPerSecondDoesNotPassPlateOf5Millimetres) {
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
        EXPECT_NEAR(w.states[0].v[3], -300 * e, e > 0 ? 3e-7 : 0.02) << "compliance leaves a small velocity of recovery";
        EXPECT_NEAR(w.states[0].v[4], 20, 1e-9);
      }
    }
  }
}

/// The plate is free to move and turn; the ball hits it obliquely and off-centre.
TEST(Swept, BallDoesNotPassFreePlate) {
  for (const double radius : {0.002, 0.02}) {
    for (const double e : {0.0, 0.5, 1.0}) {
      for (const double slant : {0.0, 0.35, 0.7}) {
        Shape ball = Shape::sphere(radius), sheet = Shape::box({0.0025, 0.5, 0.5});
        ball.restitution = sheet.restitution = e;
        StepperOptions options;
        options.gravity = {};
        World w({body("ball", ball, 8000), body("plate", sheet, 7800)}, {-100, 0, 0}, options);
        SweptContacts swept(w.scene);
        GuardedStep guard(w.scene, w.stepper);
        const Vec3 direction{std::cos(slant), 0.6 * std::sin(slant), 0.8 * std::sin(slant)};
        put(w.states[0], Vec3{-0.0025 - radius, 0.1, -0.07} - direction * 0.8);
        for (int k = 0; k < 3; ++k) w.states[0].v[static_cast<std::size_t>(3 + k)] = 300 * direction[k];
        for (int step = 0; step < 8; ++step) {
          std::vector<collision::SystemMotion> motions;
          for (std::size_t i = 0; i < 2; ++i) {
            calc_poses(w.stepper.mechanism(static_cast<int>(i)), w.states[i].q, w.poses[i]);
            motions.push_back({w.states[i].q, w.states[i].v});
          }
          const Vec3 at = w.poses[1][0].inverse() * w.poses[0][0].p;
          if (std::max(std::fabs(at.y), std::fabs(at.z)) > 0.5) break;  // m: the ball has left the plate over its edge
          ASSERT_LT(at.x, -0.0025 - radius + 2e-3) << "radius " << radius << " e " << e << " slant " << slant << " step " << step;
          collision::find_contacts(w.scene, w.spans, 0.02, w.workspace, w.contacts);
          swept.add(motions, w.spans, 0.002, 0.02, w.contacts);
          ASSERT_EQ(guard.step(w.systems, w.contacts, 0.002).status, StepStatus::ok);
        }
        EXPECT_GT(w.states[1].v[3], 0) << "the plate should have been hit";
      }
    }
  }
}

TEST(Swept, BallThatMissesPlateIsNotStopped) {
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

TEST(Swept, TwoFastBallsMatchClosedForm) {
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
  w.states[2].v[5] = -400;  // m/s: body 2 flies into the ground, which is at z = -100 m
  for (int k = 0; k < 200; ++k) ASSERT_EQ(swept_step(w, swept, 0.002).status, StepStatus::ok);
  EXPECT_NEAR(w.states[0].v[3], -100, 1e-9);
  EXPECT_NEAR(w.states[1].v[3], 250, 1e-9);
  EXPECT_NEAR(w.states[2].v[5], 400, 1e-9);
}

/// Includes speeds at which the sword turns by more than 90 degrees in a step.
TEST(Swept, SwordDoesNotPassPoleBallOrPlate) {
  for (const double speed : {5.0, 20.0, 60.0, 150.0}) {
    for (const double dt : {1.0 / 60, 0.002}) {
      for (const double angle : {0.7, 1.3, 2.3}) {
        const Pose X{rotation_about({0, 0, 1}, angle), {0.9 * std::cos(angle), 0.9 * std::sin(angle), 0}};
        for (const Shape& shape : {Shape::cylinder(0.004, 0.3, X), Shape::sphere(0.03, X), Shape::box({0.2, 0.002, 0.2}, X)}) {
          MechanismSpec spec;
          spec.name = "target";
          LinkSpec l;
          l.name = "target";
          l.shapes.push_back(shape);
          spec.links.push_back(l);
          World w({sword(0.001), Mechanism::make(std::move(spec)).value()}, {-100, 0, 0}, {});
          SweptContacts swept(w.scene);
          w.states[0].v[0] = speed;
          for (int k = 0; k < std::lround(2.5 / (speed * dt)) + 5; ++k) {
            ASSERT_EQ(swept_step(w, swept, dt).status, StepStatus::ok);
            ASSERT_LT(w.states[0].q[0], angle + 1e-3) << "speed " << speed << " dt " << dt << " step " << k;
          }
          EXPECT_GT(w.states[0].q[0], angle - 0.06) << "the sword should have come near the obstacle";
        }
      }
    }
  }
}

/// The pole rolls along the blade at thousands of rad/s, so that its surface points at the end of a step are far from their initial
/// positions.
TEST(Swept, BladePushesLightRollingPole) {
  World w({sword(0.004), body("pole", Shape::cylinder(0.004, 0.3), 1000)}, {-100, 0, 0}, {});
  SweptContacts swept(w.scene);
  GuardedStep guard(w.scene, w.stepper);
  put(w.states[1], {0, 0.8, 0});
  w.states[0].v[0] = 20;
  double lowest = 0, fastest = 0;
  for (int k = 0; k < 100; ++k) {
    std::vector<collision::SystemMotion> motions;
    for (std::size_t i = 0; i < 2; ++i) {
      calc_poses(w.stepper.mechanism(static_cast<int>(i)), w.states[i].q, w.poses[i]);
      motions.push_back({w.states[i].q, w.states[i].v});
    }
    collision::find_contacts(w.scene, w.spans, 0.02, w.workspace, w.contacts);
    lowest = std::min(lowest, w.lowest());
    swept.add(motions, w.spans, 0.002, 0.02, w.contacts);
    ASSERT_EQ(guard.step(w.systems, w.contacts, 0.002).status, StepStatus::ok);
    fastest = std::max(fastest, std::fabs(w.states[1].v[2]));
  }
  EXPECT_GT(fastest, 1000) << "the pole should roll";
  EXPECT_GT(lowest, -2e-3);
}

}  // namespace
}  // namespace ugoki::contact
