// Tests of the interpreter with the sample content and the real player.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "fake_simulation.h"
#include "ugoki/content/display_frame.h"
#include "ugoki/content/generate.h"
#include "ugoki/content/player.h"
#include "ugoki/samples/samples.h"
#include "ugoki/studio/interpreter.h"
#include "ugoki/studio/player_simulation.h"

namespace ugoki::studio {
namespace {

using nlohmann::json;
using test::Frame;

class Collector final : public InterpreterSink {
 public:
  void frame(std::span<const std::byte> bytes) override {
    last = test::parse_frame(bytes);
    EXPECT_TRUE(last.good);
    ++frames;
  }
  void message(std::string text) override {
    json j = json::parse(text);
    if (j["event"] == "stopped") ADD_FAILURE() << text;
    if (j["event"] == "summary")
      summary = std::move(j);
    else if (j["event"] == "recorded")
      recorded = std::move(j);
    else if (j["event"] == "transport")
      transport = std::move(j);
  }
  Frame last;
  int frames = 0;
  json summary, transport, recorded;
};

const std::vector<std::byte>& sample() {
  static const std::vector<std::byte> bytes = [] {
    const samples::Sample made = samples::make_sample();
    const Result<content::Scenario> scenario = content::read_scenario(made.document, "sample");
    return content::generate(*scenario, made.resources).value();
  }();
  return bytes;
}

class ContentTest : public testing::Test {
 protected:
  void SetUp() override {
    const Result<void> loaded = interpreter.load(sample());
    ASSERT_TRUE(loaded) << loaded.error().text();
  }
  void pass(double seconds) {
    const double end = now + seconds;
    while (now < end) {
      const double wait = interpreter.work();
      now += std::min(std::max(wait, 1e-6), end - now + 1e-9);
    }
  }
  void settle() {
    for (int i = 0; i < 1'000'000 && interpreter.work() == 0; ++i) {
    }
  }
  float distance(const Frame& a, const Frame& b, std::size_t character) {
    float max_difference = 0;
    for (std::size_t l = 0; l < a.characters[character].links.size(); ++l) {
      for (std::size_t i = 0; i < 3; ++i)
        max_difference = std::max(max_difference, std::abs(a.characters[character].links[l][i] - b.characters[character].links[l][i]));
    }
    return max_difference;
  }
  double now = 0;
  Collector sink;
  Interpreter interpreter{open_player, sink, [this] { return now; }};
};

TEST_F(ContentTest, EditModeShowsTheTracks) {
  const Frame start = sink.last;
  ASSERT_EQ(start.characters.size(), 3u);
  EXPECT_EQ(start.characters[0].state, 3u);
  EXPECT_GT(start.characters[0].links.size(), 15u);
  ASSERT_TRUE(interpreter.seek(2));
  EXPECT_GT(distance(start, sink.last, 0), 1.0f);  // the human walks more than 1 m in 2 s
}

TEST_F(ContentTest, SimulatedSampleFollowsItsTracks) {
  ASSERT_TRUE(interpreter.seek(1));
  const Frame track = sink.last;
  ASSERT_TRUE(interpreter.set_mode(PlayMode::simulate));
  settle();
  EXPECT_LT(distance(track, sink.last, 0), 0.3f);
  EXPECT_EQ(sink.last.characters[0].state, 0u);
  EXPECT_FALSE(sink.last.contacts.empty());
  EXPECT_NEAR(sink.last.characters[0].weight, 70 * 9.81, 70);
  ASSERT_TRUE(sink.summary.is_object());
  EXPECT_LT(sink.summary["characters"][0]["assist_rms_bw"], 0.15);
  EXPECT_FALSE(sink.summary["contacts"].empty());
}

TEST_F(ContentTest, ReplayAfterReloadAndPastPushIsBitIdentical) {
  ASSERT_TRUE(interpreter.set_mode(PlayMode::simulate));
  ASSERT_TRUE(interpreter.play(std::nullopt));
  pass(0.6);
  ASSERT_TRUE(interpreter.grab("human", "chest", {0, 0, 0}, {1, 1, 1.5}));
  EXPECT_NE(sink.last.flags & content::frame_playing, 0u);
  pass(0.2);
  ASSERT_TRUE(interpreter.drag({1, 2, 1.5}));
  pass(0.2);
  ASSERT_TRUE(interpreter.release());
  pass(0.2);
  ASSERT_TRUE(interpreter.pause());
  const double head = interpreter.simulated();
  const std::uint64_t digest = interpreter.head_digest();
  // Loading the same content recomputes it with the recorded inputs.
  ASSERT_TRUE(interpreter.load(sample()));
  settle();
  EXPECT_DOUBLE_EQ(interpreter.simulated(), head);
  EXPECT_EQ(interpreter.head_digest(), digest);
  // A push before the end of the recording (the head) changes the result. The same push gives the same bits twice.
  std::uint64_t digests[2];
  for (std::uint64_t& d : digests) {
    ASSERT_TRUE(interpreter.seek(0.75));
    ASSERT_TRUE(interpreter.push("human", "chest", {0, 150, 0}, 0.2));
    EXPECT_NEAR(interpreter.simulated(), 0.75, 0.003);
    ASSERT_TRUE(interpreter.seek(head));
    settle();
    d = interpreter.head_digest();
  }
  EXPECT_NE(digests[0], digest);
  EXPECT_EQ(digests[0], digests[1]);
}

TEST_F(ContentTest, ReportsTheStateHashOfTheNewestStep) {
  Result<content::Player> alone = content::Player::open(sample(), "sample");
  ASSERT_TRUE(alone);
  ASSERT_TRUE(interpreter.set_mode(PlayMode::simulate));
  for (int i = 0; i < 30; ++i) {
    ASSERT_TRUE(interpreter.step_tick());
    ASSERT_TRUE(alone->step());
  }
  EXPECT_EQ(sink.transport["steps"], 30);
  EXPECT_EQ(std::stoull(sink.transport["state_hash"].get<std::string>(), nullptr, 16), alone->state_hash());
}

/// The recorded curve of a joint ends with the angle that the links of the newest frame have to each other.
TEST_F(ContentTest, RecordedJointsAreThoseOfTheSimulation) {
  ASSERT_TRUE(interpreter.set_mode(PlayMode::simulate));
  ASSERT_TRUE(interpreter.seek(0.5));
  settle();
  const samples::Sample made = samples::make_sample();
  const Result<content::Scenario> scenario = content::read_scenario(made.document, "sample");
  const Mechanism& human = *made.resources.mechanisms.at(scenario->characters[0].mechanism);
  const std::string id = scenario->characters[0].id;
  int hinge = 0;
  while (human.link(hinge).joint.type != JointType::revolute) ++hinge;
  ASSERT_TRUE(interpreter.report_recorded(id, {human.link(hinge).name, human.link(0).name}));
  ASSERT_EQ(sink.recorded["curves"].size(), 1u) << "floating joints have no curve";
  const json& values = sink.recorded["curves"][0]["values"];
  ASSERT_EQ(values.size(), 1u);
  EXPECT_EQ(sink.recorded["step"], 1.0 / 60);
  EXPECT_NEAR(static_cast<double>(values[0].size()), 31, 1);
  const auto rotation = [&](int link) {
    const auto& x = sink.last.characters[0].links[static_cast<std::size_t>(link)];
    return Quat{x[3], x[4], x[5], x[6]};
  };
  const Joint& joint = human.link(hinge).joint;
  const Quat turned = to_quat(joint.X_PJ.R).conjugate() * rotation(human.link(hinge).parent).conjugate() * rotation(hinge);
  EXPECT_NEAR(values[0].back().get<double>(), 2 * std::atan2(dot(joint.axis, turned.vec()), turned.w), 1e-4);
  EXPECT_FALSE(interpreter.report_recorded("nobody", {}));
  EXPECT_FALSE(interpreter.report_recorded(id, {"wing"}));
}

TEST_F(ContentTest, GrabIsShownImmediatelyAndPulls) {
  ASSERT_TRUE(interpreter.set_mode(PlayMode::simulate));
  ASSERT_TRUE(interpreter.seek(0.5));
  settle();
  const auto ball = sink.last.characters[2].links[0];
  const Vec3 above = {ball[0], ball[1], 3};
  ASSERT_TRUE(interpreter.grab("ball", "0", {0, 0, 0}, above));
  EXPECT_NE(sink.last.flags & content::frame_grab, 0u);
  EXPECT_EQ(sink.last.grab[5], 3);
  EXPECT_EQ(sink.last.grab[0], ball[0]);
  ASSERT_TRUE(interpreter.drag({above.x, above.y, 2.5}));
  EXPECT_EQ(sink.last.grab[5], 2.5f);
  const float before = sink.last.characters[2].links[0][2];
  ASSERT_TRUE(interpreter.play(std::nullopt));
  pass(0.7);
  EXPECT_GT(sink.last.characters[2].links[0][2], before + 0.1f);
  EXPECT_NE(sink.last.flags & content::frame_grab, 0u);
  ASSERT_TRUE(interpreter.release());
  pass(0.1);
  EXPECT_EQ(sink.last.flags & content::frame_grab, 0u);
}

}  // namespace
}  // namespace ugoki::studio
