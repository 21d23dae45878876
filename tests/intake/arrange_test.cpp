// Tests of the reduction of files to one character: carrier joints, unrelated joints, other roots, other parents, walking in place.
#include "ugoki/intake/arrange.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "../body/measured_files.h"
#include "ugoki/body/body.h"
#include "ugoki/intake/scale.h"
#include "ugoki/intake/support.h"
#include "ugoki/intake/tree_edit.h"
#include "ugoki/samples/samples.h"
#include "ugoki/spatial/elementary.h"

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

TEST(Arrange, JointsWithoutABoneAreMergedOrLeftOut) {
  const MeasuredMotion plain = body::testing::made_character(30);
  MeasuredMotion rig = plain;
  const int hips = find(rig, "Hips");
  const Vec3 place = rig.skeleton.joints[static_cast<std::size_t>(find(rig, "Spine"))].offset;
  append_rigid(rig, "Carrier", hips, place, {});
  append_rigid(rig, "Point", hips, {}, {});
  std::vector<int> parents(rig.skeleton.joints.size(), -1);
  parents[static_cast<std::size_t>(find(rig, "Spine"))] = find(rig, "Carrier");
  reparent({&rig, 1}, parents);
  std::vector<std::vector<Pose>> world = world_of(rig);
  for (std::size_t f = 0; f < world.size(); ++f)
    for (const char* turned : {"Carrier", "Point"})
      world[f][static_cast<std::size_t>(find(rig, turned))].R = to_matrix(axis_angle({1, 0, 0}, 0.01 * static_cast<double>(f)));
  set_world(rig, world);
  std::vector<std::string> report;
  const body::Character character = arrange({&rig, 1}, report, nullptr, false);
  EXPECT_EQ(character.plan, body::BodyPlan::human);
  EXPECT_EQ(rig.joint_count(), plain.joint_count());
  EXPECT_EQ(std::max(find(rig, "Carrier"), find(rig, "Point")), -1);
  EXPECT_LT(max_distance(plain, rig), 1e-9);
  ASSERT_EQ(report.size(), 2u);
  EXPECT_NE(report[0].find("carry nothing were left out: Point."), std::string::npos) << report[0];
  EXPECT_NE(report[1].find("merged with it: Carrier."), std::string::npos) << report[1];
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

TEST(Arrange, RigidJointsAtTheirParentsPlaceAreMerged) {
  MeasuredMotion m;
  m.rate = 30;
  m.frames = 20;
  const auto add = [&](const char* name, int parent, const Vec3& offset) {
    SkeletonJoint j;
    j.name = name;
    j.parent = parent;
    j.offset = offset;
    m.skeleton.joints.push_back(std::move(j));
  };
  add("root", -1, {});
  add("to_leg", 0, {});        // rigid, at the same place: merged
  add("leg", 1, {0.1, 0, 0});  // turns
  add("wrist", 2, {});         // turns at the same place: kept
  add("hand", 3, {0, 0, 0.2});
  add("offset", 0, {0, 0.1, 0});  // rigid, at another place: kept
  add("end", 5, {0, 0.1, 0});
  for (int f = 0; f < m.frames; ++f)
    for (int i = 0; i < m.joint_count(); ++i) {
      m.translations.push_back(m.skeleton.joints[static_cast<std::size_t>(i)].offset);
      const bool turns = i == 0 || i == 2 || i == 3;
      m.rotations.push_back(turns ? axis_angle({0, 1, 0}, 0.1 * f + i) : Quat{});
    }
  std::vector<MeasuredMotion> motions = {m};
  EXPECT_EQ(merge_rigid_joints(motions), (std::vector<std::string>{"to_leg"}));
  ASSERT_EQ(motions[0].joint_count(), 6);
  EXPECT_EQ(motions[0].skeleton.joints[1].parent, 0);
  EXPECT_FALSE(motions[0].skeleton.joints[1].translates);
  std::vector<Pose> X, Y;
  m.calc_joint_poses(13, X);
  motions[0].calc_joint_poses(13, Y);
  for (std::size_t k = 1; k < Y.size(); ++k) EXPECT_NEAR(norm(X[k + 1].p - Y[k].p), 0, 1e-12);
}

TEST(Arrange, WalkingInPlaceIsFoundAndGetsItsTravel) {
  MeasuredMotion walk = samples::make_human_walk();
  std::vector<std::string> report;
  const MeasuredMotion before = walk;
  const body::Character character = arrange(std::span(&walk, 1), report);
  ASSERT_EQ(character.plan, body::BodyPlan::human);
  EXPECT_FALSE(find_missing_travel(character, walk).exists()) << "a walk with travel is not a walk on a treadmill";
  const std::size_t n = walk.skeleton.joints.size(), frames = static_cast<std::size_t>(walk.frames);
  const Vec3 way = walk.translations[(frames - 1) * n] - walk.translations[0];
  const Vec3 speed = Vec3{way.x, way.y, 0} / walk.duration();
  // Removes the travel with a speed that changes by the share `change`, so that the character walks in place.
  for (const double change : {0.0, 0.6}) {
    MeasuredMotion in_place = before;
    std::vector<Vec3> back;
    for (std::size_t f = 0; f < frames; ++f) {
      const double t = static_cast<double>(f) / walk.rate, period = walk.duration();
      back.push_back(speed * -(t + change * period / (2 * pi) * (1 - sin_cos(2 * pi * t / period).cos)));
    }
    add_travel(in_place, back);
    const MissingTravel travel = find_missing_travel(character, in_place);
    ASSERT_TRUE(travel.exists()) << change;
    EXPECT_LT(norm(travel.velocity - speed), (change > 0 ? 0.2 : 0.15) * norm(speed)) << change;
    add_travel(in_place, travel.shift);
    EXPECT_LT(max_distance(before, in_place), (change > 0 ? 0.3 : 0.15) * norm(way)) << change;
  }
}

/// The walk with feet that are children of the root; inverse kinematics keeps them at the ends of the shanks, as in rigs of games.
MeasuredMotion walk_with_feet_at_root() {
  const MeasuredMotion before = samples::make_human_walk();
  MeasuredMotion odd = before;
  const std::size_t n = before.skeleton.joints.size();
  std::vector<Pose> X;
  const std::vector<Vec3> rest = rest_positions(before.skeleton);
  for (const char* name : {"LeftFoot", "RightFoot"}) {
    const auto foot = static_cast<std::size_t>(find(before, name));
    for (int f = 0; f < odd.frames; ++f) {
      before.calc_joint_poses(f, X);
      const Pose local = X[0].inverse() * X[foot];
      odd.translations[static_cast<std::size_t>(f) * n + foot] = local.p;
      odd.rotations[static_cast<std::size_t>(f) * n + foot] = to_quat(local.R);
    }
    odd.skeleton.joints[foot].parent = 0;
    odd.skeleton.joints[foot].offset = rest[foot] - rest[0];
    odd.skeleton.joints[foot].translates = true;
  }
  return odd;
}

/// Adds a joint without a parent, which does not move. @param first true: before all other joints
void add_still_joint(MeasuredMotion& m, const std::string& name, const Vec3& place, bool first) {
  std::vector<std::vector<Pose>> world = world_of(m);
  SkeletonJoint joint;
  joint.name = name;
  joint.offset = place;
  joint.translates = true;
  m.skeleton.joints.insert(first ? m.skeleton.joints.begin() : m.skeleton.joints.end(), joint);
  if (first)
    for (SkeletonJoint& j : m.skeleton.joints) j.parent += j.parent >= 0 ? 1 : 0;
  for (std::vector<Pose>& X : world) X.insert(first ? X.begin() : X.end(), Pose{Mat3::identity(), place});
  set_world(m, world);
}

TEST(Arrange, ACameraFarAwayDoesNotChangeTheSizeOfTheSkeleton) {
  MeasuredMotion odd = walk_with_feet_at_root();
  add_still_joint(odd, "Camera", {-40, 30, 20}, false);
  std::vector<std::string> report;
  const body::Character character = arrange(std::span(&odd, 1), report);
  EXPECT_EQ(character.plan, body::BodyPlan::human) << character.why_not;
  EXPECT_EQ(find(odd, "Camera"), -1);
  const int foot = find(odd, "LeftFoot");
  ASSERT_GE(foot, 0);
  EXPECT_EQ(odd.skeleton.joints[static_cast<std::size_t>(odd.skeleton.joints[static_cast<std::size_t>(foot)].parent)].name, "LeftLeg");
}

TEST(Arrange, PelvisAndTrunkOnTwoBranchesAreJoined) {
  const MeasuredMotion before = samples::make_human_walk();
  for (const bool on_ground : {true, false}) {
    MeasuredMotion odd = before;
    if (on_ground) add_still_joint(odd, "Ground", {0.5, 0, 0}, true);
    const std::vector<std::vector<Pose>> world = world_of(odd);
    const std::vector<Vec3> rest = rest_positions(odd.skeleton);
    const int hips = find(odd, "Hips");
    for (std::size_t i = 0; i < odd.skeleton.joints.size(); ++i) {
      SkeletonJoint& j = odd.skeleton.joints[i];
      if (j.name != "Hips" && !(j.parent == hips && j.name.find("Spine") != std::string::npos)) continue;
      j.parent = on_ground ? 0 : -1;
      j.offset = rest[i] - (on_ground ? rest[0] : Vec3{});
      j.translates = true;
    }
    set_world(odd, world);
    ASSERT_EQ(body::recognise_character(odd).plan, body::BodyPlan::other);
    std::vector<std::string> report;
    const body::Character character = arrange(std::span(&odd, 1), report);
    EXPECT_EQ(character.plan, body::BodyPlan::human) << character.why_not;
    std::vector<Pose> X, Y;  // a joint whose direction in the tree is reversed moves to its former child
    before.calc_joint_poses(before.frames / 2, X);
    odd.calc_joint_poses(odd.frames / 2, Y);
    for (const char* name : {"Head", "LeftHand", "RightHand", "LeftFoot", "RightFoot", "LeftUpLeg"})
      EXPECT_LT(norm(X[static_cast<std::size_t>(find(before, name))].p - Y[static_cast<std::size_t>(find(odd, name))].p), 1e-9) << name;
    EXPECT_TRUE(std::ranges::any_of(report, [](const std::string& r) { return r.find("another branch") != std::string::npos; }));
  }
}

TEST(Arrange, FeetDrivenFromTheRootAreAttachedToTheirShanks) {
  const MeasuredMotion before = samples::make_human_walk();
  MeasuredMotion odd = walk_with_feet_at_root();
  EXPECT_NE(body::recognise_character(odd).plan, body::BodyPlan::human) << "the feet must be missing before";
  std::vector<std::string> report;
  const body::Character character = arrange(std::span(&odd, 1), report);
  EXPECT_EQ(character.plan, body::BodyPlan::human) << character.why_not;
  ASSERT_FALSE(report.empty());
  EXPECT_NE(report[0].find("LeftFoot"), std::string::npos) << report[0];
  for (const char* side : {"Left", "Right"}) {
    const int foot = find(odd, std::string(side) + "Foot");
    ASSERT_GE(foot, 0);
    const int parent = odd.skeleton.joints[static_cast<std::size_t>(foot)].parent;
    ASSERT_GE(parent, 0);
    EXPECT_EQ(odd.skeleton.joints[static_cast<std::size_t>(parent)].name, std::string(side) + "Leg");
  }
  EXPECT_LT(max_distance(before, odd), 1e-9);
  for (int i = 0; i < odd.joint_count(); ++i) EXPECT_LT(odd.skeleton.joints[static_cast<std::size_t>(i)].parent, i);
}

/// The walk with feet that have no parent, are listed before the body, and have the names of controls: a game rig whose paws or feet are
/// controls of inverse kinematics beside the body. In the last `lost` frames the left foot is 0.5 m away from the end of its shank.
MeasuredMotion walk_with_loose_feet(int lost) {
  const MeasuredMotion before = samples::make_human_walk();
  const auto n = static_cast<std::size_t>(before.joint_count());
  std::vector<std::size_t> order;
  const auto belongs = [&](int i) {
    for (; i >= 0; i = before.skeleton.joints[static_cast<std::size_t>(i)].parent)
      if (before.skeleton.joints[static_cast<std::size_t>(i)].name.ends_with("Foot")) return true;
    return false;
  };
  for (const bool foot : {true, false})
    for (std::size_t i = 0; i < n; ++i)
      if (belongs(static_cast<int>(i)) == foot) order.push_back(i);
  MeasuredMotion odd = before;
  odd.translations.clear();
  odd.rotations.clear();
  const std::vector<Vec3> rest = rest_positions(before.skeleton);
  std::vector<int> place(n);
  for (std::size_t k = 0; k < n; ++k) place[order[k]] = static_cast<int>(k);
  for (std::size_t k = 0; k < n; ++k) {
    SkeletonJoint& joint = odd.skeleton.joints[k] = before.skeleton.joints[order[k]];
    const bool foot = joint.name.ends_with("Foot");
    joint.parent = joint.parent < 0 || foot ? -1 : place[static_cast<std::size_t>(joint.parent)];
    if (!foot) continue;
    joint.offset = rest[order[k]];
    joint.name = joint.name.starts_with("Left") ? "IKLeg.L" : "IKLeg.R";
    joint.translates = true;
  }
  std::vector<Pose> X;
  for (int f = 0; f < before.frames; ++f) {
    before.calc_joint_poses(f, X);
    for (std::size_t k = 0; k < n; ++k) {
      const std::size_t i = order[k];
      const bool root = odd.skeleton.joints[k].parent < 0;
      const bool away = odd.skeleton.joints[k].name == "IKLeg.L" && f >= before.frames - lost;
      odd.translations.push_back(root ? X[i].p + Vec3{0, away ? 0.5 : 0.0, 0} : before.translations[static_cast<std::size_t>(f) * n + i]);
      odd.rotations.push_back(root ? to_quat(X[i].R) : before.rotations[static_cast<std::size_t>(f) * n + i]);
    }
  }
  return odd;
}

TEST(Arrange, FeetBesideTheBodyAreAttachedToTheirShanks) {
  const MeasuredMotion before = samples::make_human_walk();
  for (const int lost : {0, before.frames / 30}) {
    MeasuredMotion odd = walk_with_loose_feet(lost);
    ASSERT_NE(body::recognise_character(odd).plan, body::BodyPlan::human) << "the feet must be missing before";
    std::vector<std::string> report;
    const body::Character character = arrange(std::span(&odd, 1), report);
    ASSERT_EQ(character.plan, body::BodyPlan::human) << character.why_not;
    for (const auto& [control, shank] : {std::pair("IKLeg.L", "LeftLeg"), {"IKLeg.R", "RightLeg"}}) {
      const int foot = find(odd, control);
      ASSERT_GE(foot, 0);
      const int parent = odd.skeleton.joints[static_cast<std::size_t>(foot)].parent;
      ASSERT_GE(parent, 0);
      EXPECT_EQ(odd.skeleton.joints[static_cast<std::size_t>(parent)].name, shank);
      EXPECT_TRUE(character.legs[0].end == foot || character.legs[1].end == foot) << "the control is the foot";
      EXPECT_EQ(character.helper[static_cast<std::size_t>(foot)], 0);
    }
    if (lost == 0) EXPECT_LT(max_distance(before, odd), 1e-9);
  }
}

TEST(Arrange, ForeLimbsAtTheJointOfTheHindLimbsAreAttachedToTheSpine) {
  // A horse whose legs, rump and body are children of one joint.
  MeasuredMotion horse;
  horse.rate = 30;
  horse.frames = 40;
  const auto add = [&](const std::string& name, const char* parent, Vec3 offset, Vec3 end = {}) {
    SkeletonJoint joint;
    joint.name = name;
    joint.parent = find(horse, parent);
    joint.offset = offset;
    joint.translates = joint.parent < 0;
    if (norm(end) > 0) joint.end_sites = {end};
    horse.skeleton.joints.push_back(std::move(joint));
  };
  add("Hub", "", {0, 0, 1.2});
  add("Rump", "Hub", {-0.4, 0, 0.1});
  add("Tail", "Rump", {-0.2, 0, 0}, {-0.3, 0, -0.3});
  for (const auto& [name, x] : {std::pair<std::string, double>("Front", 0.5), {"Back", -0.4}})
    for (const auto& [side, y] : {std::pair<std::string, double>("L_", 0.15), {"R_", -0.15}}) {
      const std::string upper = side + name + "Leg_Upper", lower = side + name + "Leg_Lower", hoof = side + name + "Hoof";
      add(upper, "Hub", {x, y, 0});
      add(lower, upper.c_str(), {0, 0, -0.55});
      add(hoof, lower.c_str(), {0, 0, -0.55}, {0.1, 0, -0.05});
    }
  add("Body01", "Hub", {0.3, 0, 0.1});
  add("Neck", "Body01", {0.3, 0, 0.1});
  add("Head", "Neck", {0.3, 0, 0.4}, {0.3, 0, -0.2});
  for (int f = 0; f < horse.frames; ++f)
    for (const SkeletonJoint& j : horse.skeleton.joints) {
      horse.translations.push_back(j.offset);
      horse.rotations.push_back(axis_angle({0, 1, 0}, j.name.ends_with("Upper") ? 0.2 * ugoki::sin(0.3 * f) : 0.0));
    }
  ASSERT_EQ(body::recognise_character(horse).plan, body::BodyPlan::other) << "one joint carries all limbs";
  const MeasuredMotion before = horse;
  std::vector<std::string> report;
  const body::Character character = arrange(std::span(&horse, 1), report);
  ASSERT_EQ(character.plan, body::BodyPlan::four_legs) << character.why_not;
  EXPECT_EQ(horse.skeleton.joints[static_cast<std::size_t>(character.arms[0].proximal)].name, "L_FrontLeg_Upper");
  EXPECT_EQ(horse.skeleton.joints[static_cast<std::size_t>(character.legs[1].proximal)].name, "R_BackLeg_Upper");
  const int fore = find(horse, "R_FrontLeg_Upper");
  EXPECT_EQ(horse.skeleton.joints[static_cast<std::size_t>(horse.skeleton.joints[static_cast<std::size_t>(fore)].parent)].name, "Body01");
  EXPECT_LT(max_distance(before, horse), 1e-9);
  ASSERT_FALSE(report.empty());
  EXPECT_NE(report[0].find("L_FrontLeg_Upper"), std::string::npos) << report[0];
}

TEST(Arrange, TargetsOfInverseKinematicsAtAJointAreLeftOut) {
  // A complete skeleton with targets beside the body, at the ankles.
  const MeasuredMotion before = samples::make_human_walk();
  MeasuredMotion odd = before;
  const auto n = static_cast<std::size_t>(before.joint_count());
  for (const char* name : {"LeftFoot", "RightFoot"}) {
    SkeletonJoint target;
    target.name = std::string("Target") + name;
    target.translates = true;
    target.offset = rest_positions(before.skeleton)[static_cast<std::size_t>(find(before, name))];
    odd.skeleton.joints.push_back(std::move(target));
  }
  odd.translations.clear();
  odd.rotations.clear();
  std::vector<Pose> X;
  for (int f = 0; f < before.frames; ++f) {
    before.calc_joint_poses(f, X);
    for (std::size_t i = 0; i < n; ++i) {
      odd.translations.push_back(before.translations[static_cast<std::size_t>(f) * n + i]);
      odd.rotations.push_back(before.rotations[static_cast<std::size_t>(f) * n + i]);
    }
    for (const char* name : {"LeftFoot", "RightFoot"}) {
      odd.translations.push_back(X[static_cast<std::size_t>(find(before, name))].p);
      odd.rotations.emplace_back();
    }
  }
  std::vector<std::string> report;
  const body::Character character = arrange(std::span(&odd, 1), report);
  EXPECT_EQ(character.plan, body::BodyPlan::human) << character.why_not;
  EXPECT_EQ(odd.joint_count(), before.joint_count());
  EXPECT_EQ(find(odd, "TargetLeftFoot"), -1);
}

TEST(Arrange, AJumpToAnotherPlaceCutsTheMotion) {
  MeasuredMotion walk = samples::make_human_walk();
  std::vector<std::string> report;
  const body::Character character = arrange(std::span(&walk, 1), report);
  EXPECT_EQ(cut_at_jumps(character, walk), "");
  // The last fifth is at another place.
  MeasuredMotion cut = walk;
  const std::size_t n = walk.skeleton.joints.size();
  const int jump = walk.frames * 4 / 5;
  for (int f = jump; f < walk.frames; ++f) cut.translations[static_cast<std::size_t>(f) * n] += Vec3{-1, 2, 0};
  const std::string sentence = cut_at_jumps(character, cut);
  EXPECT_NE(sentence.find("frames 1 to " + std::to_string(jump) + " of " + std::to_string(walk.frames)), std::string::npos) << sentence;
  EXPECT_EQ(cut.frames, jump);
  EXPECT_EQ(cut.rotations.size(), n * static_cast<std::size_t>(jump));
  EXPECT_EQ(max_distance(cut, walk), 0);
}

TEST(Arrange, ACalibrationPoseBeforeTheMarkersIsCut) {
  MarkerMotion m;
  m.rate = 100;
  m.frames = 50;
  m.labels = {"A", "B", "C", "D"};
  for (int f = 0; f < m.frames; ++f)
    for (int i = 0; i < 4; ++i) {
      m.positions.push_back(Vec3{0.01 * f, 0.3 * i, 0.5 * i} + (f == 0 ? Vec3{0.4, 0.4, 0} : Vec3{}));
      // One marker that jumps alone is exchanged; this is no jump of the character.
      if (f == 30 && i == 2) m.positions.back().z += 1;
      m.residuals.push_back(0);
    }
  const std::string sentence = cut_markers_at_jumps(m);
  EXPECT_NE(sentence.find("frames 2 to 50 of 50"), std::string::npos) << sentence;
  EXPECT_EQ(m.frames, 49);
  EXPECT_EQ(m.first_frame, 2);
  EXPECT_EQ(m.at(0, 1), (Vec3{0.01, 0.3, 0.5}));
  EXPECT_EQ(cut_markers_at_jumps(m), "");
}

TEST(Support, AMissingStepIsReportedAndAJumpIsNot) {
  const MeasuredMotion walk = samples::make_human_walk();
  const auto body = body::make_body(walk);
  ASSERT_TRUE(body) << body.error().text();
  const Motion level = body::to_motion(*body, walk);
  EXPECT_EQ(describe_missing_support(*body->mechanism, level, body->height), "");
  Motion step = level;
  for (int f = step.frames / 2; f < step.frames; ++f) step.frame(f)[2] += 0.3;
  const std::string sentence = describe_missing_support(*body->mechanism, step, body->height);
  EXPECT_NE(sentence.find("does not contain"), std::string::npos);
  // A flight phase: 0.6 s on a parabola.
  Motion jump = level;
  for (int f = 0; f < jump.frames; ++f) {
    const double t = f / jump.rate - 0.2, flight = 0.6;
    if (t > 0 && t < flight) jump.frame(f)[2] += 0.5 * 9.81 * t * (flight - t);
  }
  EXPECT_EQ(describe_missing_support(*body->mechanism, jump, body->height), "");
}

TEST(Support, AMotionThatIsPulledDownIsReported) {
  const MeasuredMotion walk = samples::make_human_walk();
  const auto body = body::make_body(walk);
  ASSERT_TRUE(body) << body.error().text();
  // The root bobs by 0.05 m three times per second: its downward acceleration is up to 0.05 (6 pi)^2 = 17.8 m/s^2 = 1.8 times gravity.
  Motion bobbing = body::to_motion(*body, walk);
  for (int f = 0; f < bobbing.frames; ++f) bobbing.frame(f)[2] += 0.05 * sin_cos(6 * pi * f / bobbing.rate).sin;
  const std::string sentence = describe_missing_support(*body->mechanism, bobbing, body->height);
  EXPECT_NE(sentence.find("accelerates downwards"), std::string::npos) << sentence;
}

TEST(Support, PartsBelowTheFloorAreReported) {
  const MeasuredMotion walk = samples::make_human_walk();
  const auto body = body::make_body(walk);
  ASSERT_TRUE(body) << body.error().text();
  Motion sunken = body::to_motion(*body, walk);
  for (int f = 0; f < sunken.frames; ++f) sunken.frame(f)[2] -= 0.05 * (1 - sin_cos(2 * pi * f / sunken.frames).cos);
  const std::string sentence = describe_missing_support(*body->mechanism, sunken, body->height);
  EXPECT_NE(sentence.find("are below the floor"), std::string::npos) << sentence;
  EXPECT_NE(sentence.find("by up to 1"), std::string::npos) << "10 cm, and the depth of the feet: " << sentence;
}

TEST(Support, SlidingFeetAreReported) {
  const MeasuredMotion walk = samples::make_human_walk();
  const auto body = body::make_body(walk);
  ASSERT_TRUE(body) << body.error().text();
  Motion in_place = body::to_motion(*body, walk);
  for (int f = 0; f < in_place.frames; ++f)
    for (int k = 0; k < 2; ++k) in_place.frame(f)[k] = in_place.frame(0)[k];
  const std::string sentence = describe_missing_support(*body->mechanism, in_place, body->height);
  EXPECT_NE(sentence.find("slides over it"), std::string::npos) << sentence;
  EXPECT_EQ(describe_missing_support(*body->mechanism, in_place, body->height, true), "") << "the report states that it walks on a belt";
}

TEST(Support, HoveringHeightsCloseTheGapToTheFloorButNotFlights) {
  const MeasuredMotion walk = samples::make_human_walk();
  const auto body = body::make_body(walk);
  ASSERT_TRUE(body) << body.error().text();
  const Motion level = body::to_motion(*body, walk);
  EXPECT_TRUE(hovering_heights(*body->mechanism, level, body->height).empty());
  // The root bobs by up to 0.15 m once in 1.4 s, with a downward acceleration of at most 1.5 m/s^2: slower than a fall.
  Motion bobbing = level;
  const auto lift = [&](int f) {
    const double s = sin_cos(pi * f / bobbing.rate / 1.4).sin;
    return 0.15 * s * s;
  };
  for (int f = 0; f < bobbing.frames; ++f) bobbing.frame(f)[2] += lift(f);
  const std::vector<double> heights = hovering_heights(*body->mechanism, bobbing, body->height);
  ASSERT_EQ(heights.size(), static_cast<std::size_t>(bobbing.frames));
  for (int f = 0; f < bobbing.frames; ++f) EXPECT_NEAR(heights[static_cast<std::size_t>(f)], lift(f), 0.02) << f;
  // Something else carries a character that stays in the air.
  Motion high = level;
  for (int f = high.frames / 4; f < high.frames; ++f) high.frame(f)[2] += 1.0;
  EXPECT_TRUE(hovering_heights(*body->mechanism, high, body->height).empty());
  Motion jump = level;
  for (int f = 0; f < jump.frames; ++f) {
    const double t = f / jump.rate - 0.2, flight = 0.6;
    if (t > 0 && t < flight) jump.frame(f)[2] += 0.5 * 9.81 * t * (flight - t);
  }
  for (const double h : hovering_heights(*body->mechanism, jump, body->height)) EXPECT_LT(h, 0.05);
}

TEST(Support, ASittingCharacterIsReportedAndAStandingOneIsNot) {
  MeasuredMotion stand = samples::make_human_stand();
  auto body = body::make_body(stand);
  ASSERT_TRUE(body) << body.error().text();
  const Motion upright = body::to_motion(*body, stand);
  EXPECT_EQ(describe_missing_support(*body->mechanism, upright, body->height), "");
  // The same character on a chair: thighs forward, pelvis lower and behind the feet.
  const auto joint = [&](const std::string& name) {
    const auto& joints = stand.skeleton.joints;
    const auto found = std::ranges::find(joints, name, &SkeletonJoint::name);
    EXPECT_NE(found, joints.end()) << name;
    return static_cast<std::size_t>(found - joints.begin());
  };
  const std::size_t n = stand.skeleton.joints.size();
  const Quat forward = axis_angle({0, 1, 0}, -0.5 * pi), down = axis_angle({0, 1, 0}, 0.5 * pi);
  for (std::size_t f = 0; f < static_cast<std::size_t>(stand.frames); ++f) {
    for (const char* side : {"Left", "Right"}) {
      Quat& hip = stand.rotations[f * n + joint(std::string(side) + "UpLeg")];
      Quat& knee = stand.rotations[f * n + joint(std::string(side) + "Leg")];
      hip = forward * hip;
      knee = down * knee;
    }
    stand.translations[f * n].z -= 0.42;
  }
  const Motion sitting = body::to_motion(*body, stand);
  const std::string sentence = describe_missing_support(*body->mechanism, sitting, body->height);
  EXPECT_NE(sentence.find("cannot balance the character"), std::string::npos) << sentence;
}

}  // namespace
}  // namespace ugoki::intake
