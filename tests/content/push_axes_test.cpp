// Axes of pushes: JSON form, and the motion of a spinning ball, which is pushed along a fixed direction or along one that turns with it.

#include <gtest/gtest.h>

#include "command_fixture.h"

namespace ugoki::content {
namespace {

using testing::make_scenario;

constexpr double spin = 2, force = 3, mass = 0.4, begin = 0.1, duration = 0.8, step = 0.002;  // rad/s, N, kg, s

class PushAxesTest : public testing::CommandFixture {
 protected:
  PushAxesTest() {
    document = make_scenario();
    document.events.clear();
    apply(R"({"type": "event.add", "event": {"type": "throw", "time": 0, "character": "ball", "from": [3, 0, 40], "velocity": [0, 0, 0],
        "spin": [0, 0, 2]}})");
  }
  void push(const std::string& fields) {
    apply(R"({"type": "event.add", "event": {"type": "push", "time": 0.1, "duration": 0.8, "character": "ball", "link": "ball",
        "force": [3, 0, 0])" +
          fields + "}}");
  }
  /// Velocity of the ball over the floor after the push, m/s.
  Vec3 speed() {
    Player player = open();
    while (player.time() < begin + duration + 0.01) EXPECT_TRUE(player.step());
    const std::span<const double> v = player.v(1);
    return {v[3], v[4], 0};
  }
};

TEST_F(PushAxesTest, WorldAxesGiveTheImpulseAlongOneDirection) {
  push("");
  const Vec3 v = speed();
  EXPECT_NEAR(v.x, force * duration / mass, 1e-6);
  EXPECT_NEAR(v.y, 0, 1e-6);
}

/// The force has the direction (cos wt, sin wt), so the velocity is force / (mass w) (sin b - sin a, cos a - cos b), with the angles a and
/// b of the ball at its begin and end. The ball turns from the end of the first step on, and the force has the direction of the begin of
/// each step, so that the angles are those of 1.5 steps before.
TEST_F(PushAxesTest, BodyAxesTurnWithTheBody) {
  push(R"(, "axes": "body")");
  const Vec3 v = speed();
  const double size = force / (mass * spin), a = spin * (begin - 1.5 * step), b = a + spin * duration;
  EXPECT_NEAR(v.x, size * (std::sin(b) - std::sin(a)), 1e-5);
  EXPECT_NEAR(v.y, size * (std::cos(a) - std::cos(b)), 1e-5);
}

TEST_F(PushAxesTest, RulesPushInBodyAxesToo) {
  apply(R"({"type": "rule.add", "rule": {"mode": "when", "if": [{"type": "time", "time": 0.1}],
      "do": {"type": "push", "character": "ball", "link": "ball", "force": [3, 0, 0], "axes": "body", "duration": 0.8}}})");
  const Vec3 v = speed();
  const double size = force / (mass * spin), end = begin + duration;
  EXPECT_NEAR(v.x, size * (std::sin(spin * end) - std::sin(spin * begin)), 0.02 * size);
  EXPECT_NEAR(v.y, size * (std::cos(spin * begin) - std::cos(spin * end)), 0.02 * size);
}

TEST_F(PushAxesTest, DocumentKeepsTheAxes) {
  push(R"(, "axes": "body")");
  EXPECT_EQ(document.events.back().axes, PushAxes::body);
  const std::string text = write_scenario(document);
  EXPECT_NE(text.find(R"("axes": "body")"), std::string::npos);
  const Result<Scenario> read = read_scenario(text, "scenario");
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_EQ(*read, document);
  apply(R"({"type": "event.set", "id": ")" + document.events.back().id + R"(", "event": {"axes": "world"}})");
  EXPECT_EQ(write_scenario(document).find("axes"), std::string::npos) << "world axes are not written, as before there was a choice";
}

TEST_F(PushAxesTest, OtherAxesAreRefused) {
  refuses(R"({"type": "event.add", "event": {"type": "push", "time": 0, "character": "ball", "link": "ball", "axes": "screen"}})",
          ErrorCode::unsupported, "command/event/axes");
}

}  // namespace
}  // namespace ugoki::content
