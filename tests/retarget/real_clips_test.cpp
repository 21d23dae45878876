// Retargets twenty measured clips to a child, a giant, two humanoid robots and a dog.

#include <gtest/gtest.h>

#include "characters.h"
#include "ugoki/retarget/retarget.h"
#include "ugoki/samples/samples.h"

namespace ugoki::retarget_test {
namespace {

const std::vector<std::string> clips = {
    "human/asf_amc/01_01.amc", "human/asf_amc/02_01.amc", "human/asf_amc/02_02.amc", "human/asf_amc/02_03.amc",
    "human/asf_amc/02_04.amc", "human/asf_amc/02_05.amc", "human/asf_amc/02_09.amc", "human/asf_amc/03_01.amc",
    "human/asf_amc/05_01.amc", "human/asf_amc/06_01.amc", "human/asf_amc/07_01.amc", "human/asf_amc/08_01.amc",
    "human/asf_amc/10_04.amc", "human/asf_amc/16_15.amc", "human/asf_amc/32_01.amc", "human/asf_amc/35_01.amc",
    "human/asf_amc/38_01.amc", "human/asf_amc/55_04.amc", "human/bvh/131_02.bvh",    "human/bvh/cmu_12_01_walk.bvh"};

/// Checks joint limits and sliding of every clip, then calls `more`(path, retargeted).
template <class More>
void check_clips(const MechanismPtr& character, const More& more) {
  if (!character) GTEST_SKIP() << "The shared data are absent.";
  for (const std::string& path : clips) {
    Clip clip;
    if (!load_clip(path, clip)) GTEST_SKIP() << "The shared data are absent.";
    const auto out = retarget::retarget(clip.mechanism, clip.motion, character);
    ASSERT_TRUE(out) << path << ": " << out.error().text();
    EXPECT_LE(worst_excess(*character, out->motion), 0) << path;
    EXPECT_LT(worst_skate(*character, out->motion), 0.01) << path;
    more(path, *out);
  }
}

void check_all(const MechanismPtr& character) {
  check_clips(character, [](const std::string& path, const retarget::Retargeted& out) {
    double lost = 0, standing = 0;  // number of frames in which a standing foot misses the ground, and of all frames with a standing foot
    for (const retarget::Miss& miss : out.report.misses)
      for (const ContactTrack& track : out.motion.contacts)
        if (track.link == miss.link) lost += miss.frames;
    for (const ContactTrack& track : out.motion.contacts)
      for (const std::uint8_t on : track.on) standing += on;
    EXPECT_LT(lost, 0.05 * standing) << path;
  });
}

TEST(Slow_RealClips, Child) { check_all(make_person(1.1)); }
TEST(Slow_RealClips, Giant) { check_all(make_person(2.4)); }
TEST(Slow_RealClips, SimpleHumanoid) {
  check_all(load_robot("mechanism/open_chain/urdf/simple_humanoid_description/urdf/simple_humanoid.urdf"));
}
/// This model's ankles cannot reach the planned orientation and its soles consist of balls; standing feet must not slide nevertheless.
TEST(Slow_RealClips, MujocoHumanoidDoesNotSlide) {
  const MechanismPtr character = load_robot("mechanism/open_chain/mujoco/model__humanoid__humanoid.xml");
  check_clips(character, [&](const std::string& path, const retarget::Retargeted& out) {
    EXPECT_NEAR(worst_skate(*character, out.motion), out.report.skate_after, 1e-6) << path;
  });
}
TEST(Slow_RealClips, Dog) { check_all(samples::make_dog()); }

}  // namespace
}  // namespace ugoki::retarget_test
