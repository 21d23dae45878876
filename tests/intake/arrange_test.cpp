// Tests of the reduction of files to one character: carrier joints, unrelated joints, other roots, other parents, walking in place.
#include "ugoki/intake/arrange.h"

#include <gtest/gtest.h>

#include "../body/measured_files.h"
#include "ugoki/samples/samples.h"

namespace ugoki::intake {
namespace {

int find(const MeasuredMotion& m, const std::string& name) {
  for (int i = 0; i < m.joint_count(); ++i)
    if (m.skeleton.joints[static_cast<std::size_t>(i)].name == name) return i;
  return -1;
}

/// Maximum distance [m] between joints of the same name in all frames.
double max_distance(const MeasuredMotion& a, const MeasuredMotion& b) {
  double worst = 0;
  std::vector<Pose> X, Y;
  for (int f = 0; f < a.frames; ++f) {
    a.calc_joint_poses(f, X);
    b.calc_joint_poses(f, Y);
    for (int i = 0; i < a.joint_count(); ++i) {
      const int k = find(b, a.skeleton.joints[static_cast<std::size_t>(i)].name);
      if (k >= 0) worst = std::max(worst, norm(X[static_cast<std::size_t>(i)].p - Y[static_cast<std::size_t>(k)].p));
    }
  }
  return worst;
}

TEST(Arrange, AnotherRootKeepsTheOtherJointsInTheWorld) {
  const MeasuredMotion before = body::testing::made_character(30);
  MeasuredMotion after = before;
  make_root(after, find(after, "Chest"));
  EXPECT_EQ(after.skeleton.joints[0].name, "Chest");
  std::vector<Pose> X, Y;
  for (int f = 0; f < before.frames; ++f) {
    before.calc_joint_poses(f, X);
    after.calc_joint_poses(f, Y);
    for (const char* name : {"Chest", "Head", "LeftHand", "LeftUpLeg", "RightToeBase"}) {
      const auto i = static_cast<std::size_t>(find(before, name)), k = static_cast<std::size_t>(find(after, name));
      EXPECT_LT(norm(X[i].p - Y[k].p), 1e-12) << name;
    }
    // A reversed joint has the position of its former child and keeps its orientation.
    const auto hips = static_cast<std::size_t>(find(before, "Hips")), spine = static_cast<std::size_t>(find(before, "Spine"));
    EXPECT_LT(norm(Y[static_cast<std::size_t>(find(after, "Hips"))].p - X[spine].p), 1e-12);
    EXPECT_LT(norm((Y[static_cast<std::size_t>(find(after, "Hips"))].R - X[hips].R).column(0)), 1e-12);
  }
}

TEST(Arrange, ARootAtTheChestGivesTheSameCharacter) {
  MeasuredMotion motion = body::testing::made_character(60);
  make_root(motion, find(motion, "Chest"));
  std::vector<std::string> report;
  const body::Character character = arrange(std::span(&motion, 1), report);
  EXPECT_EQ(character.plan, body::BodyPlan::human) << character.why_not;
  EXPECT_EQ(motion.skeleton.joints[0].name, "Hips");
  ASSERT_FALSE(report.empty());
  EXPECT_NE(report.front().find("re-rooted"), std::string::npos);
}

TEST(Arrange, JointsAreAttachedToTheAncestorThatCarriesThem) {
  // The thighs are children of the spine, as in files of 3ds Max Biped, but move with the hips.
  const MeasuredMotion before = samples::make_human_walk();
  const int hips = 0, spine = find(before, "Spine");
  ASSERT_GE(spine, 0);
  MeasuredMotion odd = before;
  const auto thigh = static_cast<std::size_t>(find(before, "LeftUpLeg"));
  if (thigh < static_cast<std::size_t>(spine)) GTEST_SKIP() << "The spine does not precede the legs in the sample.";
  const std::size_t n = before.skeleton.joints.size();
  std::vector<Pose> X;
  for (int f = 0; f < odd.frames; ++f) {
    before.calc_joint_poses(f, X);
    const Pose local = X[static_cast<std::size_t>(spine)].inverse() * X[thigh];
    odd.translations[static_cast<std::size_t>(f) * n + thigh] = local.p;
    odd.rotations[static_cast<std::size_t>(f) * n + thigh] = to_quat(local.R);
  }
  odd.skeleton.joints[thigh].parent = spine;
  const std::vector<std::string> names = attach_to_rigid_ancestors(std::span(&odd, 1));
  EXPECT_EQ(names.size(), 1U);
  EXPECT_EQ(odd.skeleton.joints[thigh].parent, hips);
  EXPECT_LT(max_distance(before, odd), 1e-9);
}

TEST(Arrange, WalkingInPlaceIsFoundAndGetsItsTravel) {
  MeasuredMotion walk = samples::make_human_walk();
  std::vector<std::string> report;
  const MeasuredMotion before = walk;
  const body::Character character = arrange(std::span(&walk, 1), report);
  ASSERT_EQ(character.plan, body::BodyPlan::human);
  EXPECT_FALSE(belt_velocity(character, walk)) << "a walk with travel is not a walk on a treadmill";
  const std::size_t n = walk.skeleton.joints.size();
  const Vec3 travel = walk.translations[static_cast<std::size_t>(walk.frames - 1) * n] - walk.translations[0];
  const Vec3 speed = Vec3{travel.x, travel.y, 0} / walk.duration();
  add_travel(walk, speed);  // removes the travel, so that the character walks in place
  const auto belt = belt_velocity(character, walk);
  ASSERT_TRUE(belt);
  EXPECT_LT(norm(*belt + speed), 0.15 * norm(speed));
  add_travel(walk, *belt);
  EXPECT_LT(max_distance(before, walk), 0.15 * norm(travel));
}

}  // namespace
}  // namespace ugoki::intake
