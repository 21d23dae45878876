// The Blender add-on simulates an armature and puts the motion back. It runs the program `ugoki` that $UGOKI_BIN names.
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
  EXPECT_EQ(number_after(output, "ACTIONS"), 2) << "the measured action is kept";
  const double start = number_after(output, "START"), mean = number_after(output, "MEAN"), worst = number_after(output, "WORST");
  EXPECT_GE(start, 0) << output;
  EXPECT_LT(start, 1e-4) << "m: the simulation starts at the measured pose";
  EXPECT_GT(mean, 1e-3) << "m: it is a simulation, not a copy";
  EXPECT_LT(worst, 0.15) << "m: and follows the measured walk";
  EXPECT_LT(number_after(output, "STRETCH"), 1e-4) << "m: bones keep their lengths";
  EXPECT_LT(number_after(output, "KEPT"), 1e-4) << "m: the measured action still gives the measured motion";
  EXPECT_LT(number_after(output, "BEFORE"), 1e-4) << "m: before the push the motion is the same";
  EXPECT_GT(number_after(output, "AFTER"), 0.02) << "m: the push moves the body";
}

}  // namespace
}  // namespace ugoki
