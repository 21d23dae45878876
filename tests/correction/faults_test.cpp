// Ten faults are planted in clean motions and removed. The results are judged as recorded, and as dynamics without assist.

#include "faults.h"

#include <gtest/gtest.h>

#include <cmath>

#include "../motion_edit/characters.h"
#include "ugoki/content/generate.h"
#include "ugoki/content/player.h"
#include "ugoki/correction/correct.h"

namespace ugoki::correction {
namespace {

using motion_edit::at;
using motion_edit::Character;

/// Plays the motion as dynamics without root assist. @return measures of naturalness
content::PlayerMeasures play(const Character& c, const Motion& motion) {
  content::Scenario s;
  s.duration = motion.duration();
  content::ScenarioCharacter character;
  character.id = character.name = "c";
  character.mechanism = "m";
  character.control.assist_limit = 0;
  content::ScenarioClip clip;
  clip.id = "k1";
  clip.motion = "n";
  clip.length = motion.duration();
  character.track = {clip};
  s.characters = {character};
  content::Resources resources;
  resources.mechanisms["m"] = c.mechanism;
  resources.motions["n"] = std::make_shared<const Motion>(motion);
  auto player = content::Player::open(content::generate(s, resources).value()).value();
  for (int k = 0; k < static_cast<int>(s.duration / s.step); ++k) EXPECT_TRUE(player.step());
  return player.measures(0);
}

/// The recording, corrected: a motion without faults.
Character clean(const std::string& skeleton, const std::string& trial) {
  const MeasuredMotion measured = motion_edit::read_recording(skeleton, trial);
  const body::Body body = body::make_body(measured, {}).value();
  Character c{body.mechanism, body::to_motion(body, measured)};
  c.motion = correct_motion(c.m(), c.motion).value();
  return c;
}

void expect_natural(const Character& c, const Motion& motion, const CorrectionReport& report) {
  // Limits of `ugoki judge` (docs/naturalness.md)
  EXPECT_LE(report.after.skate_cm, 3);
  EXPECT_LE(report.after.penetration_mm, 20);
  EXPECT_LE(report.after.limit_deg, 3);
  const content::PlayerMeasures run = play(c, motion);
  EXPECT_FALSE(run.fell);
  EXPECT_LE(run.tracking_rms_deg, 5);
  EXPECT_LE(run.foot_skate_cm, 3);
  EXPECT_LE(run.penetration_mm, 20);
}

TEST(Faults, AreRemovedFromAWalk) {
  if (!motion_edit::has_recordings()) GTEST_SKIP() << "the shared data were not found";
  const Character c = clean("35", "35_01");
  for (const Fault& fault : faults()) {
    SCOPED_TRACE(fault.name);
    const Motion wrong = fault.plant(c.m(), c.motion);
    CorrectionReport report;
    const auto out = correct_motion(c.m(), wrong, {}, &report);
    ASSERT_TRUE(out) << out.error().text();
    expect_natural(c, *out, report);
    EXPECT_LE(report.after.residual_bw, fault.name == "mistimed" ? 0.15 : 0.05) << "body weights";
    // Joints stay as in the clean motion, in all frames: rms below 2 degrees. Two faults change all frames of their joints.
    ASSERT_EQ(out->frames, c.motion.frames);
    if (fault.name == "jerky" || fault.name == "mistimed") continue;
    double sum = 0, d[6];
    int count = 0;
    for (int f = 0; f < out->frames; ++f)
      for (std::size_t i = 1; i < c.m().links().size(); ++i) {
        const Link& link = c.m().links()[i];
        if (link.joint.nv() == 0) continue;
        joint_difference(link.joint, c.motion.frame(f) + link.q_index, out->frame(f) + link.q_index, d);
        for (int k = 0; k < link.joint.nv(); ++k) sum += d[k] * d[k];
        ++count;
      }
    EXPECT_LT(std::sqrt(sum / count) * 180 / pi, 2) << "degrees";
  }
}

TEST(Faults, WrongGravityIsRemovedFromAJump) {
  if (!motion_edit::has_recordings()) GTEST_SKIP() << "the shared data were not found";
  const Character c = clean("02", "02_04");
  for (const Fault& fault : faults()) {
    if (fault.name != "gravity") continue;
    const Motion heavy = fault.plant(c.m(), c.motion);
    CorrectionReport report;
    const auto out = correct_motion(c.m(), heavy, {}, &report);
    ASSERT_TRUE(out) << out.error().text();
    EXPECT_GT(report.before.flight_g, 0.4);
    EXPECT_LT(report.after.flight_g, 0.15);
    // The flight regains its duration: sqrt(1.5) times that of the wrong one, and the frames around it become slower too.
    EXPECT_GT(report.duration_change, 0.05);
    EXPECT_LE(report.after.skate_cm, 3);
    EXPECT_LE(report.after.penetration_mm, 20);
    const auto same = correct_motion(c.m(), heavy, {.keep_duration = true}, &report);
    ASSERT_TRUE(same) << same.error().text();
    EXPECT_EQ(same->frames, heavy.frames);
  }
}

TEST(Faults, AreRemovedFromTheSampleWalk) {
  Character c = motion_edit::human_walk();
  c.motion = motion_edit::unrolled(c.m(), c.motion, 3);
  for (const Fault& fault : faults()) {
    SCOPED_TRACE(fault.name);
    CorrectionReport report;
    const auto out = correct_motion(c.m(), fault.plant(c.m(), c.motion), {}, &report);
    ASSERT_TRUE(out) << out.error().text();
    EXPECT_LE(report.after.skate_cm, 3);
    EXPECT_LE(report.after.penetration_mm, 20);
    EXPECT_LE(report.after.residual_bw, 0.15);
    EXPECT_LE(report.after.residual_bw, report.before.residual_bw);
  }
}

}  // namespace
}  // namespace ugoki::correction
