// Torque-oriented motion data: conversion in both directions, and replay.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "ugoki/content/player.h"
#include "ugoki/content/torque_conversion.h"
#include "ugoki/formats/motion_binary.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion/torques.h"
#include "ugoki/samples/samples.h"

namespace ugoki::content {
namespace {

/// The walking human of the sample, alone. The stride is repeated.
struct Walk {
  explicit Walk(double duration) : sample(samples::make_sample()) {
    scenario = read_scenario(sample.document, "sample").value();
    std::erase_if(scenario.characters, [](const ScenarioCharacter& c) { return c.id != "human"; });
    scenario.events.clear();
    scenario.rules.clear();
    scenario.camera.follow.clear();
    scenario.duration = duration;
  }
  samples::Sample sample;
  Scenario scenario;
};

std::uint64_t hash_after(const Scenario& scenario, const Resources& resources, int steps) {
  Result<Player> player = Player::open(generate(scenario, resources).value());
  EXPECT_TRUE(player) << (player ? "" : player.error().text());
  for (int k = 0; k < steps; ++k) EXPECT_TRUE(player->step());
  return player->state_hash();
}

/// Maximum over all joint DOFs of the RMS difference [degrees] between two motions of the same rate.
double largest_rms_difference(const Mechanism& m, const Motion& a, const Motion& b) {
  EXPECT_EQ(a.frames, b.frames);
  EXPECT_NEAR(a.rate, b.rate, 1e-9);
  std::vector<double> d(static_cast<std::size_t>(m.nv())), squares(d.size());
  for (int f = 0; f < std::min(a.frames, b.frames); ++f) {
    const auto n = static_cast<std::size_t>(a.nq);
    difference(m, {a.frame(f), n}, {b.frame(f), n}, d);
    for (std::size_t i = 0; i < d.size(); ++i)
      if (i < 3 || i >= 6) squares[i] += d[i] * d[i];
  }
  return std::sqrt(*std::max_element(squares.begin(), squares.end()) / a.frames) * 180 / pi;
}

const Motion& motion_of(const ConvertedContent& c, const std::string& id) { return *c.resources.motions.at(id); }

TEST(TorqueMotion, AWalkWithoutAssistReplaysItsTorquesBitForBit) {
  Walk walk(2);
  walk.scenario.characters[0].control.assist_limit = 0;
  ConversionOptions options;
  options.own_control = true;
  const auto torques = to_torques(walk.scenario, walk.sample.resources, options);
  ASSERT_TRUE(torques) << torques.error().text();
  EXPECT_TRUE(torques->replays);
  ASSERT_EQ(torques->characters.size(), 1u);
  EXPECT_EQ(torques->characters[0].root_max_bw, 0) << "no force on the root: the torques of the joints alone make the walk";
  EXPECT_LT(torques->characters[0].deviation.rms_deg, 6);
  const Motion& motion = motion_of(torques->content, torques->characters[0].motion);
  ASSERT_NE(torques_of(motion), nullptr);
  EXPECT_EQ(torques_of(motion)->steps(), 1000u);
  const std::uint64_t once = hash_after(torques->content.scenario, torques->content.resources, 1000);
  // Independent of the first run: a read and written motion in a new player.
  ConvertedContent copy = torques->content;
  copy.resources.motions[torques->characters[0].motion] =
      std::make_shared<const Motion>(formats::read_motion(formats::write_motion(motion), "copy").value());
  EXPECT_EQ(hash_after(copy.scenario, copy.resources, 1000), once);
  copy.scenario.ground.height = -0.001;  // other content: the same torques make another motion
  EXPECT_NE(hash_after(copy.scenario, copy.resources, 1000), once);
}

TEST(TorqueMotion, ThereAndBackWithinHalfADegree) {
  Walk walk(2);
  walk.scenario.characters[0].control.assist_limit = 0;
  ConversionOptions own;
  own.own_control = true;
  const auto first = to_torques(walk.scenario, walk.sample.resources, own);
  ASSERT_TRUE(first) << first.error().text();
  const auto angles = to_angles(first->content.scenario, first->content.resources);
  ASSERT_TRUE(angles) << angles.error().text();
  EXPECT_LT(angles->characters[0].deviation.rms_deg, 0.05) << "between two frames of the coordinates";
  const auto second = to_torques(angles->content.scenario, angles->content.resources);
  ASSERT_TRUE(second) << second.error().text();
  EXPECT_TRUE(second->replays);
  EXPECT_LT(second->characters[0].root_rms_bw, 0.01) << "a physical walk needs hardly any force on its root";
  const auto again = to_angles(second->content.scenario, second->content.resources);
  ASSERT_TRUE(again) << again.error().text();
  const Mechanism& m = *walk.sample.resources.mechanisms.at(walk.scenario.characters[0].mechanism);
  EXPECT_LT(largest_rms_difference(m, motion_of(angles->content, angles->characters[0].motion),
                                   motion_of(again->content, again->characters[0].motion)),
            0.5);
}

TEST(TorqueMotion, PathModeFollowsAWalkThatIsNotPhysical) {
  Walk walk(2);
  const auto torques = to_torques(walk.scenario, walk.sample.resources);
  ASSERT_TRUE(torques) << torques.error().text();
  EXPECT_TRUE(torques->replays);
  EXPECT_LT(torques->characters[0].deviation.rms_deg, 1);
  EXPECT_GT(torques->characters[0].root_rms_bw, 0.01) << "the report names the force that no joint supplies";
}

TEST(TorqueMotion, ChangedCoordinatesHaveNoTorques) {
  Walk walk(0.2);
  const auto torques = to_torques(walk.scenario, walk.sample.resources);
  ASSERT_TRUE(torques) << torques.error().text();
  Motion motion = motion_of(torques->content, torques->characters[0].motion);
  ASSERT_NE(torques_of(motion), nullptr);
  motion.q[0] += 1e-12;
  EXPECT_EQ(torques_of(motion), nullptr);
  Resources resources = torques->content.resources;
  resources.motions[torques->characters[0].motion] = std::make_shared<const Motion>(motion);
  const auto refused = generate(torques->content.scenario, resources);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().text().find("has no torques"), std::string::npos) << refused.error().text();
}

TEST(TorqueMotion, RefusesContentThatCannotReplay) {
  Walk walk(0.2);
  const auto torques = to_torques(walk.scenario, walk.sample.resources);
  ASSERT_TRUE(torques) << torques.error().text();
  Scenario s = torques->content.scenario;
  s.step = 0.001;
  auto refused = generate(s, torques->content.resources);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().text().find("steps of 0.002 s"), std::string::npos) << refused.error().text();
  s = torques->content.scenario;
  s.characters[0].track[0].start = 0.1;
  refused = generate(s, torques->content.resources);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().text().find("one clip"), std::string::npos) << refused.error().text();
  EXPECT_FALSE(to_angles(walk.scenario, walk.sample.resources)) << "no character has torques";
  walk.scenario.characters[0].control.mode = ControlMode::passive;
  EXPECT_FALSE(to_torques(walk.scenario, walk.sample.resources)) << "no character follows a track";
}

TEST(TorqueMotion, ConversionCanBeCancelled) {
  Walk walk(2);
  ConversionOptions options;
  options.progress = [](double done) { return done < 0.1; };
  const auto made = to_torques(walk.scenario, walk.sample.resources, options);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().problems[0].code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace ugoki::content
