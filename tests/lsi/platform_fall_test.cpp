// The LSI `balance control` of a character that falls on a platform above the ground plane of the world.

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "small_world.h"
#include "ugoki/body/body.h"
#include "ugoki/samples/samples.h"

namespace ugoki::lsi {
namespace {

constexpr double top = 2;  // m: height of the platform above the ground plane

/// A fixed box of 12 m x 12 m.
MechanismPtr make_platform() {
  MechanismSpec spec;
  spec.name = "platform";
  LinkSpec link;
  link.name = "platform";
  link.joint.type = JointType::fixed;
  link.shapes = {Shape::box({6, 6, 0.5 * top}, {Mat3::identity(), {0, 0, 0.5 * top}})};
  spec.links = {link};
  return make_checked(std::move(spec));
}

/// A human who stands on the platform and is pushed ahead after 0.5 s. @param impulse N s per kg of body mass
World make_world(double impulse) {
  const MeasuredMotion stand = samples::make_human_stand();
  const body::Body body = body::make_body(stand).value();
  auto motion = std::make_shared<Motion>(body::to_motion(body, stand));
  motion->cyclic = true;
  std::vector<CharacterSpec> specs(2);
  specs[0].id = "human";
  specs[0].mechanism = body.mechanism;
  TrackClip clip;
  clip.motion = motion;
  clip.clip.length = 30;
  clip.clip.loop = true;
  clip.clip.placement.z = top;
  specs[0].track = {clip};
  specs[1].id = "platform";
  specs[1].mechanism = make_platform();
  ScheduledEvent push;
  push.record.kind = EventKind::push;
  push.record.a = {impulse * body.mechanism->mass() / 0.2, 0, 0};
  push.time = 0.5;
  push.duration = 0.2;
  return World(std::move(specs), {push}, Vec3{0, 0, -9.81}, collision::Ground{});
}

TEST(PlatformFall, ACharacterOnAPlatformFallsLiesGetsUpAndStands) {
  const World world = make_world(4);
  const circuit::Circuit circuit = make_execution_circuit({{"human", true, 1, 1, 0}, {"platform", false, 1, 1, 0.5}}, 0.002);
  auto run = circuit::Interpreter::build(circuit, standard_library(), &world, {.dt = 0.002, .check_finite = true});
  ASSERT_TRUE(run) << run.error().text();
  const auto recovery = run->find_output("human/control.recovery");
  ASSERT_TRUE(recovery);
  std::vector<int> modes;  // without repetitions
  double standing = 0, lowest = 1e9, last = 0;
  for (int k = 0; k < 8000; ++k) {
    ASSERT_TRUE(run->tick());
    const int mode = static_cast<int>(recovery->numbers()[0]);
    last = numbers(*run, "state")[2] - top;
    if (k == 0) standing = last;
    if (modes.empty() || modes.back() != mode) modes.push_back(mode);
    // A body that lies is near the platform, not near the ground plane 2 m below it.
    if (mode == 3) lowest = std::min(lowest, last);
  }
  for (const int mode : {2, 3, 4}) EXPECT_TRUE(std::ranges::find(modes, mode) != modes.end()) << "never in mode " << mode << ", modes " << testing::PrintToString(modes);
  EXPECT_EQ(modes.back(), 0);
  EXPECT_GT(lowest, 0);
  EXPECT_LT(lowest, 0.5 * standing);
  EXPECT_NEAR(last, standing, 0.1);
}

}  // namespace
}  // namespace ugoki::lsi
