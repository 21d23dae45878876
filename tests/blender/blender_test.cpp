// Blender opens the BVH and GLB files that we write and finds every joint at its position within 1e-4 m.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "run_blender.h"
#include "ugoki/base/number.h"
#include "ugoki/formats/asf.h"
#include "ugoki/formats/bvh.h"
#include "ugoki/formats/gltf.h"
#include "ugoki/samples/samples.h"

namespace ugoki {
namespace {

/// The value that the script prints after `word`; negative if it does not print it.
double number_after(const std::string& output, const std::string& word) {
  const std::size_t at = output.find(word + " ");
  return at == std::string::npos ? -1 : std::atof(output.c_str() + at + word.size() + 1);
}

void expect_blender_agrees(const MeasuredMotion& m) {
  const TemporaryFolder folder;
  ASSERT_FALSE(folder.path.empty());
  std::string expected = "rate " + to_text(m.rate) + "\n";
  std::vector<Pose> X(static_cast<std::size_t>(m.joint_count()));
  int count = 0;
  for (int k = 0; k < 12; ++k) {
    const int frame = k * (m.frames - 1) / 11;
    if (k > 0 && frame == (k - 1) * (m.frames - 1) / 11) continue;
    expected += "frame " + std::to_string(frame) + "\n";
    m.calc_joint_poses(frame, X);
    for (std::size_t j = 0; j < X.size(); ++j) {
      const Vec3 p = X[j].p;  // the files have Y up and Z forward; Blender converts them to Z up and -Y forward
      expected += to_text(p.y) + " " + to_text(-p.x) + " " + to_text(p.z) + " " + m.skeleton.joints[j].name + "\n";
      ++count;
    }
  }
  std::ofstream(folder.path + "/expected.txt") << expected;
  std::ofstream(folder.path + "/m.bvh") << formats::write_bvh(m, {.metres_per_unit = 1});
  const std::vector<std::byte> glb = formats::write_glb(m);
  std::ofstream(folder.path + "/m.glb", std::ios::binary)
      .write(reinterpret_cast<const char*>(glb.data()), static_cast<std::streamsize>(glb.size()));
  for (const char* file : {"m.bvh", "m.glb"}) {
    SCOPED_TRACE(m.name + " " + file);
    const auto [status, output] = run_blender("joint_positions.py", folder.path + "/" + file + " " + folder.path + "/expected.txt", folder);
    ASSERT_EQ(status, 0) << output;
    EXPECT_EQ(number_after(output, "FOUND"), count) << output;
    const double worst = number_after(output, "WORST");
    EXPECT_GE(worst, 0);
    EXPECT_LT(worst, 1e-4) << output;
    std::printf("%s %s: maximum error %.3g m\n", m.name.c_str(), file, worst);
  }
}

TEST(Slow_Blender, FindsTheJointsOfOurFiles) {
  if (!blender_is_installed()) GTEST_SKIP() << "Blender is not installed";
  expect_blender_agrees(samples::make_human_walk());
  const std::string data = UGOKI_SHARED_DATA "/human/";
  for (const char* name : {"bvh/cmu_12_01_walk.bvh", "bvh/131_02.bvh"}) {
    const std::string text = text_of_file(data + name);
    if (text.empty()) continue;
    const auto m = formats::read_bvh(text, name);
    ASSERT_TRUE(m.has_value());
    expect_blender_agrees(*m);
  }
  for (const char* trial : {"02_01", "02_05"}) {
    const std::string skeleton = text_of_file(data + "asf_amc/02.asf"), text = text_of_file(data + "asf_amc/" + trial + ".amc");
    if (skeleton.empty() || text.empty()) continue;
    const auto asf = formats::read_asf(skeleton, "02.asf");
    const auto m = formats::read_amc(text, trial, *asf);
    ASSERT_TRUE(m.has_value());
    expect_blender_agrees(*m);
  }
}

}  // namespace
}  // namespace ugoki
