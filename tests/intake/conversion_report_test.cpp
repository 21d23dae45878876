#include "ugoki/intake/conversion_report.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "ugoki/body/body.h"
#include "ugoki/formats/asf.h"
#include "ugoki/formats/bvh.h"
#include "ugoki/intake/intake.h"
#include "ugoki/samples/samples.h"

namespace ugoki::intake {
namespace {

TEST(ConversionReport, LongListsAreShortened) {
  EXPECT_EQ(list_of({}), "");
  EXPECT_EQ(list_of({"a"}), "a");
  EXPECT_EQ(list_of({"a", "b", "c"}), "a, b and c");
  EXPECT_EQ(list_of({"a", "b", "c", "d", "e"}, 2), "a, b and 3 more");
  EXPECT_EQ(list_of({"a", "b", "c"}, 2), "a, b and c") << "\"1 more\" would not be shorter";
}

TEST(ConversionReport, RemarksAreSortedByKeyPhrases) {
  ConversionReport r;
  r.add_remarks({"The AMC format does not specify the frame rate; 120 frames per second are assumed.",
                 "3 missing frames were filled by interpolation.",
                 "The description of force platform 2 is incomplete; the platform is left out.",
                 "This is a poor fit: check that the labels are correct and that left and right are not exchanged.",
                 "The joint on line 3 has no name; it was named 'joint'.", "3 missing frames were filled by interpolation."});
  EXPECT_EQ(r.guessed.size(), 1u);
  EXPECT_EQ(r.changed.size(), 2u);
  EXPECT_EQ(r.left_out.size(), 1u);
  EXPECT_EQ(r.check.size(), 1u);
  EXPECT_TRUE(r.read.empty());
}

std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

const std::filesystem::path data_folder = UGOKI_SHARED_DATA;

/// A shared file of every kind gets a report that describes its contents in complete sentences.
TEST(ConversionReport, EveryKindOfFileIsReported) {
  if (!std::filesystem::exists(data_folder)) GTEST_SKIP() << "no shared data at " << data_folder;
  const std::string asf_text = bytes_of(data_folder / "human/asf_amc/02.asf");
  const auto asf = formats::read_asf(asf_text, "02.asf");
  ASSERT_TRUE(asf);
  const struct {
    const char* path;
    const char* contents;  ///< expected part of ConversionReport::read
  } files[] = {{"human/bvh/cmu_12_01_walk.bvh", "joints:"}, {"human/asf_amc/02_01.amc", "343 frames at 120 Hz, 2.85 s"},
               {"human/c3d/02_01.c3d", "41 markers:"},      {"animal/rat_walk_23.trc", "23 markers:"},
               {"gltf/Fox.glb", "motions of one skeleton"}, {"mechanism/open_chain/urdf/simple_humanoid.urdf", "degrees of freedom"}};
  for (const auto& file : files) {
    std::filesystem::path path = data_folder / file.path;
    if (!std::filesystem::exists(path)) {
      path = data_folder / "animal" / path.filename();
      if (!std::filesystem::exists(path)) continue;
    }
    const auto intake = take_in(bytes_of(path), path.filename().string(), &*asf);
    if (!intake) {  // a recording that cannot be solved gives an error with a message
      EXPECT_FALSE(intake.error().problems.front().message.empty());
      continue;
    }
    const ConversionReport& r = intake->conversion;
    EXPECT_TRUE(std::ranges::any_of(r.read, [&](const std::string& line) { return line.find(file.contents) != std::string::npos; }))
        << file.path << ": " << (r.read.empty() ? "nothing" : r.read.front());
    for (const auto* part : {&r.read, &r.guessed, &r.changed, &r.left_out, &r.check})
      for (const std::string& line : *part) EXPECT_TRUE(line.ends_with('.') || line.ends_with(')')) << file.path << ": " << line;
  }
}

/// The jump out of a calibration pose, which the conversion replaces, does not count as a speed of the motion.
TEST(ConversionReport, OnlyPeopleThatLieAreReported) {
  MeasuredMotion lying = samples::make_human_walk();
  const auto body = body::make_body(lying);
  ASSERT_TRUE(body) << body.error().text();
  const std::size_t n = lying.skeleton.joints.size();
  for (std::size_t k = 0; k < lying.rotations.size(); k += n) lying.rotations[k] = axis_angle({0, 1, 0}, 1.6) * lying.rotations[k];
  const auto lies = [&](const body::Body& b) {
    ConversionReport report;
    describe(report, b, lying);
    return std::ranges::any_of(report.check, [](const std::string& s) { return s.find("lies on its side") != std::string::npos; });
  };
  EXPECT_TRUE(lies(*body));
  body::Body animal = *body;  // the head of an animal that grazes is as low
  animal.anatomy.plan = "four legs";
  animal.human = false;
  EXPECT_FALSE(lies(animal));
}

TEST(ConversionReport, ReplacedCalibrationFramesAreNotChecked) {
  MeasuredMotion walk = samples::make_human_walk();
  const std::size_t n = walk.skeleton.joints.size();
  const auto speed_is_reported = [](const MeasuredMotion& m) {
    const auto intake = take_in(formats::write_bvh(m), "walk.bvh");
    EXPECT_TRUE(intake);
    return intake && std::ranges::any_of(intake->conversion.check, [](const std::string& s) { return s.find("m/s") != std::string::npos; });
  };
  EXPECT_FALSE(speed_is_reported(walk));
  for (std::size_t i = 0; i < n; ++i) walk.rotations[i] = walk.rotations[i] * exp_map({0.9, -1.1, 0.8});
  walk.rate = 120;
  ASSERT_EQ(body::count_calibration_frames(walk), 1);
  EXPECT_FALSE(speed_is_reported(walk));
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t k = 20 * n + i;
    walk.rotations[k] = walk.rotations[k] * exp_map({0.9, -1.1, 0.8});
  }
  EXPECT_TRUE(speed_is_reported(walk)) << "a jump within the motion is reported";
}

}  // namespace
}  // namespace ugoki::intake
