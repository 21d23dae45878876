// The Blender add-on simulates the motion of an armature and puts the result back on it. The add-on runs the program $UGOKI_BIN.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "run_blender.h"

namespace ugoki {
namespace {

double number_after(const std::string& output, const std::string& word) {
  const std::size_t at = output.find("\n" + word + " ");
  return at == std::string::npos ? -1 : std::atof(output.c_str() + at + word.size() + 2);
}

TEST(Slow_BlenderAddon, PutsTheSimulatedMotionOnTheArmature) {
  const std::string motion = UGOKI_SHARED_DATA "/human/bvh/cmu_12_01_walk.bvh";
  if (!blender_is_installed()) GTEST_SKIP() << "Blender is not installed";
  if (std::getenv("UGOKI_BIN") == nullptr || !std::filesystem::exists(motion))
    GTEST_SKIP() << "UGOKI_BIN is not set, or the shared data is missing";
  const TemporaryFolder folder;
  const auto [status, output] = run_blender("addon.py", UGOKI_SOURCE_DIR "/integrations/blender/ugoki_blender.py " + motion, folder);
  ASSERT_EQ(status, 0) << output;
  EXPECT_NE(output.find("STATUS {'FINISHED'}"), std::string::npos) << output;
  EXPECT_EQ(number_after(output, "ACTIONS"), 2) << "the measured action should be kept";
  const double start = number_after(output, "START"), mean = number_after(output, "MEAN"), worst = number_after(output, "WORST");
  EXPECT_GE(start, 0) << output;
  EXPECT_LT(start, 1e-4) << "m: the simulation should start at the measured pose";
  EXPECT_GT(mean, 1e-3) << "m: the result should be a simulation, not a copy of the measured motion";
  EXPECT_LT(worst, 0.15) << "m: the simulation should follow the measured walk";
  EXPECT_LT(number_after(output, "STRETCH"), 1e-4) << "m: bones should keep their lengths";
  EXPECT_LT(number_after(output, "KEPT"), 1e-4) << "m: the measured action should still give the measured motion";
  EXPECT_LT(number_after(output, "BEFORE"), 1e-4) << "m: before the push the motion should be the same";
  EXPECT_GT(number_after(output, "AFTER"), 0.02) << "m: the push should move the body";
}

}  // namespace
}  // namespace ugoki
