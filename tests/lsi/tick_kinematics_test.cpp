#include "ugoki/lsi/tick_kinematics.h"

#include <gtest/gtest.h>

#include "../mechanism/chain.h"

namespace ugoki::lsi {
namespace {

void hinge_only(int, LinkSpec& link) {
  link.joint.type = JointType::revolute;
  link.inertia = Inertia::from_centre(1, {}, {1, 1, 1, 0, 0, 0});
}

/// Leaves the kinematics of a hinge at the angle `angle` [rad].
void leave(TickKinematics& kinematics, const void* writer, std::uint64_t tick, const Mechanism& m, double angle) {
  dynamics::KnownKinematics values(m);
  values.update(m, {&angle, 1}, {&angle, 1});
  kinematics.leave(writer, tick, 0, values);
}

bool has(const TickKinematics& kinematics, std::uint64_t tick, double angle) {
  return kinematics.at(tick, 0).find({&angle, 1}, {&angle, 1}) != nullptr;
}

TEST(TickKinematics, AreReadInTheNextTick) {
  const MechanismPtr hinge = testing::make_chain(1, hinge_only);
  TickKinematics kinematics({&hinge, 1});
  const int writer = 0;
  kinematics.claim(&writer);
  for (std::uint64_t tick = 0; tick < 5; ++tick) {
    const double angle = static_cast<double>(tick);
    leave(kinematics, &writer, tick, *hinge, angle);
    EXPECT_TRUE(has(kinematics, tick + 1, angle));
    EXPECT_FALSE(has(kinematics, tick, angle));
    if (tick > 0) EXPECT_TRUE(has(kinematics, tick, angle - 1));  // readers of this tick are not disturbed
  }
}

TEST(TickKinematics, HaveOneWriter) {
  const MechanismPtr hinge = testing::make_chain(1, hinge_only);
  TickKinematics kinematics({&hinge, 1});
  const int first = 0, second = 0;
  kinematics.claim(&first);
  kinematics.claim(&second);
  leave(kinematics, &second, 0, *hinge, 1);
  EXPECT_FALSE(has(kinematics, 1, 1));
  kinematics.release(&second);
  leave(kinematics, &first, 0, *hinge, 2);
  EXPECT_TRUE(has(kinematics, 1, 2));
  kinematics.release(&first);
  kinematics.claim(&second);
  leave(kinematics, &second, 2, *hinge, 3);
  EXPECT_TRUE(has(kinematics, 3, 3));
}

}  // namespace
}  // namespace ugoki::lsi
