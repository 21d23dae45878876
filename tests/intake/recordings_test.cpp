// Import of marker recordings and glTF files into library entries.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>

#include "ugoki/formats/gltf.h"
#include "ugoki/intake/intake.h"

namespace ugoki::intake {
namespace {

std::string slurp(const std::string& file) {
  std::ifstream in(std::string(UGOKI_SOURCE_DIR) + "/../shared/data/" + file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

int count_of(const Intake& intake, store::EntryKind kind) {
  int count = 0;
  for (const store::LibraryItem& item : intake.items) count += item.kind == kind ? 1 : 0;
  return count;
}

bool reports(const Intake& intake, const std::string& words) {
  for (const std::string& sentence : intake.report)
    if (sentence.find(words) != std::string::npos) return true;
  return false;
}

TEST(Recordings, HumanMarkersGiveAMovingBody) {
  const std::string bytes = slurp("human/c3d/02_01.c3d");
  if (bytes.empty()) GTEST_SKIP() << "no shared data";
  const auto intake = take_in(bytes, "02_01.c3d");
  ASSERT_TRUE(intake.has_value()) << intake.error().text();
  ASSERT_TRUE(intake->body && intake->motion);
  EXPECT_TRUE(intake->body->human);
  EXPECT_NEAR(intake->body->height, 1.75, 0.12);
  EXPECT_EQ(intake->motion->frames, 343);
  EXPECT_EQ(intake->items.size(), 3U);
  EXPECT_TRUE(reports(*intake, "The worst marker is"));
}

TEST(Recordings, RatKeyPointsGiveAMovingBody) {
  const std::string bytes = slurp("animal/rat_walk_23.trc");
  if (bytes.empty()) GTEST_SKIP() << "no shared data";
  const auto intake = take_in(bytes, "rat_walk_23.trc");
  ASSERT_TRUE(intake.has_value()) << intake.error().text();
  ASSERT_TRUE(intake->body && intake->motion);
  EXPECT_FALSE(intake->body->human);
  EXPECT_GT(intake->body->mass, 0.01);
  EXPECT_LT(intake->body->mass, 2);
  EXPECT_EQ(intake->motion->frames, 1000);
}

TEST(Recordings, EveryAnimationOfAGltfFileMovesTheSameBody) {
  const std::string bytes = slurp("animal/fox-animations.glb");
  if (bytes.empty()) GTEST_SKIP() << "no shared data";
  const auto intake = take_in(bytes, "fox-animations.glb");
  ASSERT_TRUE(intake.has_value()) << intake.error().text();
  EXPECT_EQ(count_of(*intake, store::EntryKind::mechanism), 1);
  EXPECT_EQ(count_of(*intake, store::EntryKind::motion), 14);
  EXPECT_EQ(count_of(*intake, store::EntryKind::measured), 14);
  EXPECT_TRUE(reports(*intake, "14 motions"));
  EXPECT_GT(intake->body->mass, 2) << "kg: the mass of the body is that by which the unit was chosen";
  EXPECT_LT(intake->body->mass, 14);
}

// A short motion shows less of an animal than all motions of its file.
TEST(Recordings, AChosenAnimationHasPartsAndSizeByAllAnimations) {
  const std::string bytes = slurp("animal/fox-animations.glb");
  if (bytes.empty()) GTEST_SKIP() << "no shared data";
  const auto all = take_in(bytes, "fox-animations.glb");
  ASSERT_TRUE(all.has_value()) << all.error().text();
  for (std::size_t k = 0; k < all->takes.size(); k += 3) {
    IntakeOptions options;
    options.take = std::to_string(k + 1);
    const auto one = take_in(bytes, "fox-animations.glb", nullptr, options);
    ASSERT_TRUE(one.has_value()) << one.error().text();
    EXPECT_EQ(one->metres_per_unit, all->metres_per_unit) << all->takes[k];
    EXPECT_EQ(one->body->anatomy.plan, "four legs") << all->takes[k];
    EXPECT_EQ(one->measured->name, all->takes[k]);
    EXPECT_EQ(count_of(*one, store::EntryKind::motion), 1);
  }
}

TEST(Recordings, MotionWrittenAsGlbIsReadBack) {
  MeasuredMotion m;
  m.name = "swing";
  m.rate = 30;
  m.frames = 10;
  m.skeleton.name = "arm";
  for (int i = 0; i < 3; ++i) {
    SkeletonJoint j;
    j.name = "joint" + std::to_string(i);
    j.parent = i - 1;
    j.offset = {0, 0, i == 0 ? 1.0 : 0.3};
    if (i == 2) j.end_sites = {{0, 0, 0.3}};
    m.skeleton.joints.push_back(j);
  }
  for (int f = 0; f < m.frames; ++f)
    for (int i = 0; i < 3; ++i) {
      m.translations.push_back(m.skeleton.joints[static_cast<std::size_t>(i)].offset);
      m.rotations.push_back(axis_angle({0, 1, 0}, 0.05 * f * (i + 1)));
    }
  const std::vector<std::byte> glb = formats::write_glb(m);
  const auto intake = take_in({reinterpret_cast<const char*>(glb.data()), glb.size()}, "swing.glb");
  ASSERT_TRUE(intake.has_value()) << intake.error().text();
  EXPECT_EQ(intake->motion->name, "swing");
  EXPECT_EQ(intake->motion->frames, 10);
  EXPECT_EQ(intake->mechanism->link_count(), 3);
}

TEST(Recordings, BrokenFilesAreRejectedWithTheirName) {
  for (const char* name : {"a.c3d", "a.trc", "a.glb", "a.gltf"}) {
    const auto intake = take_in("nonsense", name);
    ASSERT_FALSE(intake.has_value()) << name;
    EXPECT_TRUE(intake.error().problems[0].location.starts_with(name)) << intake.error().text();
  }
}

}  // namespace
}  // namespace ugoki::intake
