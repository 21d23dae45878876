// The bodies of all shared motion files and of synthetic creatures stand in their mean pose.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "creatures.h"
#include "outcome.h"
#include "ugoki/files/files.h"
#include "ugoki/formats/asf.h"
#include "ugoki/formats/bvh.h"

namespace ugoki::dialects {
namespace {

namespace fs = std::filesystem;

/// Paths of the shared motion files, relative to the shared data.
std::vector<std::string> motion_files() {
  std::vector<std::string> out;
  std::error_code none;
  for (const char* folder : {"human/bvh", "human/asf_amc", "human/c3d", "human/trc", "animal", "gltf"})
    for (const auto& entry : fs::directory_iterator(std::string(UGOKI_SHARED_DATA) + "/" + folder, none)) {
      const std::string ending = entry.path().extension().string();
      for (const char* known : {".bvh", ".amc", ".c3d", ".trc", ".glb", ".gltf"})
        if (ending == known) out.push_back(std::string(folder) + "/" + entry.path().filename().string());
    }
  std::ranges::sort(out);
  return out;
}

Result<intake::Intake> import(const std::string& file) {
  const std::string path = std::string(UGOKI_SHARED_DATA) + "/" + file;
  if (!file.ends_with(".amc")) return intake::take_in(*files::read_file(path), file);
  const auto asf = formats::read_asf(*files::read_file(path.substr(0, path.rfind('/') + 3) + ".asf"), "skeleton");
  if (!asf) return fail(asf.error());
  return intake::take_in(*files::read_file(path), file, &*asf);
}

TEST(SlowStanding, EverySharedMotionFileStandsInItsMeanPose) {
  const std::vector<std::string> files = motion_files();
  if (files.empty()) GTEST_SKIP() << "The shared data are absent.";
  int stood = 0;
  for (const std::string& file : files) {
    SCOPED_TRACE(file);
    const auto in = import(file);
    // Rigid parts that move as wholes (a box and its lid) are a mesh, and the report states this.
    if (file == "gltf/box_animated.gltf") {
      ASSERT_TRUE(in) << in.error().text();
      EXPECT_TRUE(in->mesh && !in->motion);
      EXPECT_NE(in->report.back().find("it contains no body"), std::string::npos) << in->report.back();
    }
    if (!in || !in->motion) continue;  // refused with a reason; the tests of shared_data check which
    const Outcome o = stand(*in);
    std::printf("%-40s %-6s %8.3f m %9.3f kg  %6.2f deg  %.3f bw  %s %s\n", file.c_str(), in->body->human ? "human" : "other",
                in->body->height, in->body->mass, o.tracking, o.assist, o.released >= 0 ? "RELEASED" : "", o.error.c_str());
    EXPECT_EQ(o.error, "");
    // Two poses cannot be balanced, so control is released: a bird in flight, whose feet are not under its weight, and a rod on its end.
    if (file == "animal/bird-animations.glb" || file == "human/bvh/sinusoidal.bvh") continue;
    EXPECT_LT(o.released, 0) << "released at " << o.released << " s";
    ++stood;
  }
  EXPECT_GE(stood, 39);
}

TEST(Standing, SyntheticCreaturesStandInTheirMeanPose) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const MeasuredMotion creature = make_creature(seed);
    SCOPED_TRACE(creature.name);
    formats::BvhWriteOptions unit;
    unit.metres_per_unit = 0.001;
    intake::IntakeOptions options;
    options.unit = 0.001;
    const auto in = intake::take_in(formats::write_bvh(creature, unit), "creature.bvh", nullptr, options);
    ASSERT_TRUE(in) << in.error().text();
    const Outcome o = stand(*in);
    std::printf("%-14s %-6s joints %3d  %8.3f m %9.4f kg  %6.2f deg  %.3f bw  %s %s\n", creature.name.c_str(),
                in->body->human ? "human" : "other", creature.joint_count(), in->body->height, in->body->mass, o.tracking, o.assist,
                o.released >= 0 ? "RELEASED" : "", o.error.c_str());
    EXPECT_LT(o.released, 0) << "released at " << o.released << " s";
    EXPECT_EQ(o.error, "");
  }
}

}  // namespace
}  // namespace ugoki::dialects
