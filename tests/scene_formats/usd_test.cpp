// USD text: world positions against those computed here, the composition of transformations, and faults.
#include "ugoki/scene_formats/usd.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <string>

namespace ugoki::scene_formats {
namespace {

std::string seed(const std::string& name) {
  std::ifstream in(std::string(UGOKI_SOURCE_DIR) + "/tests/fuzz/seeds/usda/" + name);
  return {std::istreambuf_iterator<char>(in), {}};
}

Vec3 position(const MeasuredMotion& m, int frame, int joint) {
  std::vector<Pose> X;
  m.calc_joint_poses(frame, X);
  return X[static_cast<std::size_t>(joint)].p;
}

TEST(Usd, PosesAreThoseOfTheFile) {
  formats::ReadNotes notes;
  const auto m = read_usd(seed("arm.usda"), "folder/arm.usda", {}, &notes);
  ASSERT_TRUE(m.has_value()) << m.error().text();
  EXPECT_EQ(m->name, "arm");
  EXPECT_EQ(m->frames, 3);
  EXPECT_EQ(m->rate, 24);
  ASSERT_EQ(m->joint_count(), 3);
  EXPECT_EQ(m->skeleton.joints[1].name, "elbow");
  EXPECT_EQ(m->skeleton.joints[2].parent, 1);
  EXPECT_EQ(notes.metres_per_unit, 0.01);
  EXPECT_FALSE(notes.z_up);
  // The file turns the model by 90 degrees about Y, through the point (0, 0, 5), and then moves it along X. Y up: (x, y, z) becomes (z, x,
  // y).
  for (int f = 0; f < 3; ++f) {
    const double swing = f * pi / 2, travel = 10.0 * f;
    const auto world = [&](double y, double z) {  // of a point (0, y, z) of the model; the rotation turns Z to X
      const Vec3 p{z - 5 + travel, y, 5};
      return Vec3{p.z, p.x, p.y} * 0.01;
    };
    EXPECT_LT(norm(position(*m, f, 0) - world(100, 0)), 1e-9) << f;
    EXPECT_LT(norm(position(*m, f, 1) - world(130, 0)), 1e-9) << f;
    EXPECT_LT(norm(position(*m, f, 2) - world(130 + 25 * std::cos(swing), 25 * std::sin(swing))), 1e-6) << f;
  }
}

TEST(Usd, AnimatedPrimsAreJointsIfThereIsNoSkeleton) {
  formats::ReadNotes notes;
  const auto m = read_usd(seed("clock.usda"), "clock.usda", {}, &notes);
  ASSERT_TRUE(m.has_value()) << m.error().text();
  ASSERT_EQ(m->joint_count(), 2);
  EXPECT_EQ(m->frames, 3);  // time codes 0, 24, 48 at 24 a second
  EXPECT_EQ(m->rate, 1);
  EXPECT_TRUE(notes.z_up);
  std::vector<Pose> X;
  m->calc_joint_poses(1, X);
  EXPECT_LT(norm(X[0].p - Vec3{0, 0, 2}), 1e-12);
  EXPECT_LT(norm(X[0].R * Vec3{0, 1, 0} - Vec3{0, 0, 1}), 1e-12);  // a quarter turn about X
  EXPECT_LT(norm(X[1].p - Vec3{0, 0, 0.25}), 1e-12);               // its stack is reset
}

std::string with(const std::string& from, const std::string& to) {
  std::string text = seed("arm.usda");
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(Usd, UnselectedVariantsAreNotRead) {
  const auto m = read_usd(with("pose = \"moving\"", "pose = \"still\""), "arm.usda");
  ASSERT_TRUE(m.has_value()) << m.error().text();
  ASSERT_EQ(m->frames, 2);  // the model still travels, with two samples
  for (int f = 0; f < 2; ++f) EXPECT_LT(norm(position(*m, f, 2) - position(*m, f, 1) - Vec3{0, 0, 0.25}), 1e-9);
}

TEST(Usd, RotationsBetweenSamplesAreInterpolated) {
  const auto m = read_usd(with("3: (20, 0, 0)", "1.5: (5, 0, 0), 2.5: (15, 0, 0), 3: (20, 0, 0)"), "arm.usda", {.rate = 48});
  ASSERT_TRUE(m.has_value()) << m.error().text();
  EXPECT_EQ(m->frames, 5);
  const Vec3 hand = position(*m, 1, 2) - position(*m, 1, 1);
  EXPECT_LT(norm(hand - Vec3{0, 0.25 * std::sin(pi / 4), 0.25 * std::cos(pi / 4)}), 1e-8);
}

void fails(const std::string& text, const std::string& words) {
  const auto m = read_usd(text, "bad.usda");
  ASSERT_FALSE(m.has_value()) << words;
  EXPECT_NE(m.error().text().find(words), std::string::npos) << m.error().text();
  EXPECT_TRUE(m.error().problems[0].location.starts_with("bad.usda")) << m.error().text();
}

TEST(Usd, FaultsAreNamedWithTheirLine) {
  fails("", "empty");
  fails("PXR-USDC\x01", "usdcat");
  fails(std::string("PK\x03\x04") + "abcd", "usdcat");
  fails("def Xform \"A\" {}", "#usda");
  fails("#usda 1.0\ndef Xform \"A\" {", "'}'");
  fails("#usda 1.0\ndef Xform \"A\" {}\n}", "a prim");
  fails("#usda 1.0\n", "no skeleton");
  fails("#usda 1.0\n( subLayers = [@walk.usda@] )\n", "usdcat --flatten");
  fails("#usda 1.0\ndef Skeleton \"S\" { uniform token[] joints = [\"a\", \"a/b\"] }", "neither bindTransforms nor restTransforms");
  fails(with("quatf[] rotations.timeSamples = { 1: [(1, 0, 0, 0)]", "quatf[] rotations.timeSamples = { 1: [(1, 0, 0)]"),
        "rotations has 3 numbers, but 1 joints need 4");
  fails(with("(0, 100, 0, 1))", "(0, 1e10, 0, 1))"), "bad.usda:");
  fails(with("[\"shoulder\", ", "[\"shoulder\", \"shoulder\", "), "twice");
  fails(with("xformOp:rotateXYZ = (0, 90, 0)", "xformOp:rotateXYZ = (0, 90)"), "2 numbers");
  std::string deep = "#usda 1.0\n";
  for (int i = 0; i < 500; ++i) deep += "def Xform \"A\" {\n";
  fails(deep, "more than 200 times");
}

}  // namespace
}  // namespace ugoki::scene_formats
