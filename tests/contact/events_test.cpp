#include <gtest/gtest.h>

#include "ugoki/contact/contact_events.h"
#include "world.h"

namespace ugoki::contact {
namespace {

TEST(ContactEvents, BouncingBallReportsImpulseOfItsMomentum) {
  Shape shape = Shape::sphere(0.1);
  shape.restitution = 0.5;
  World w({body("ball", shape, 500)}, {}, {});
  put(w.states[0], {0, 0, 1.1});
  ContactEvents events;
  std::vector<TouchEvent> seen;
  for (int i = 0; i < 3000; ++i) {
    ASSERT_EQ(w.step(0.001).status, StepStatus::ok);
    for (const TouchEvent& e : events.update(w.contacts, w.stepper.contact_forces(), 0.001)) seen.push_back(e);
  }
  ASSERT_GE(seen.size(), 5U);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(seen[i].phase, i % 2 == 0 ? TouchPhase::begin : TouchPhase::end);
  const double speed = std::sqrt(2 * 9.81), mass = w.stepper.mechanism(0).mass();
  EXPECT_NEAR(seen[1].touch.impulse.z, 1.5 * speed * mass, 0.02 * speed * mass);
  EXPECT_NEAR(seen[3].touch.impulse.z, 0.75 * speed * mass, 0.02 * speed * mass);
  EXPECT_LT(seen[1].touch.duration, 0.0045);
  EXPECT_EQ(seen[0].touch.link_a, 0);
  EXPECT_EQ(seen[0].touch.system_b, -1);
  EXPECT_NEAR(seen[0].touch.point.z, 0, 5e-3);
  EXPECT_EQ(events.touches().size(), 1U) << "the ball rests on the ground";
  EXPECT_EQ(seen.size() % 2, 1U);
  EXPECT_GT(events.touches()[0].duration, 0.5);
}

}  // namespace
}  // namespace ugoki::contact
