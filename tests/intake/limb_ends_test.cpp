// Rigs with few bones: limbs with one or two bones, and limbs that all have the trunk as their joint.
#include "ugoki/intake/limb_ends.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "ugoki/body/recognise.h"
#include "ugoki/intake/arrange.h"

namespace ugoki::intake {
namespace {

struct Bone {
  std::string name;
  int parent;
  Vec3 offset, end;
};

/// A motion in which every joint with a parent swings about y, with another phase for each joint.
MeasuredMotion moving(const std::vector<Bone>& bones) {
  MeasuredMotion m;
  m.rate = 30;
  m.frames = 40;
  for (const Bone& b : bones) {
    SkeletonJoint j;
    j.name = b.name;
    j.parent = b.parent;
    j.offset = b.offset;
    if (norm(b.end) > 0) j.end_sites.push_back(b.end);
    j.translates = b.parent < 0;
    m.skeleton.joints.push_back(std::move(j));
  }
  for (int f = 0; f < m.frames; ++f)
    for (std::size_t i = 0; i < bones.size(); ++i) {
      m.translations.push_back(bones[i].offset);
      m.rotations.push_back(bones[i].parent < 0 ? Quat{} : axis_angle({0, 1, 0}, 0.2 * std::sin(0.3 * f + 0.9 * static_cast<double>(i))));
    }
  return m;
}

std::vector<Bone> horse(bool names) {
  std::vector<Bone> b = {{"spine", -1, {0, 0, 1.2}, {}},
                         {"neck", 0, {0.75, 0, 0.2}, {}},
                         {"head", 1, {0.5, 0, 0.5}, {0.4, 0, -0.2}},
                         {"tail", 0, {-0.75, 0, 0.1}, {-0.3, 0, -0.4}}};
  for (const double fore : {1.0, -1.0})
    for (const double side : {1.0, -1.0}) {
      const std::string s = std::string(fore > 0 ? "f" : "h") + (side > 0 ? "l" : "r");
      const int upper = static_cast<int>(b.size());
      b.push_back({names ? "up_" + s : "Bone" + std::to_string(upper), 0, {0.6 * fore, 0.2 * side, -0.1}, {}});
      b.push_back({names ? "lo_" + s : "Bone" + std::to_string(upper + 1), upper, {0, 0, -0.5}, {0, 0, -0.6}});
    }
  return b;
}

/// Trunk, neck, head and tail of an animal.
std::vector<Bone> spine() {
  return {{"Torso", -1, {0, 0, 0.8}, {}},
          {"Chest", 0, {0.7, 0, 0}, {}},
          {"Neck", 1, {0.2, 0, 0.2}, {}},
          {"Head", 2, {0.3, 0, 0.3}, {0.4, 0, -0.2}},
          {"Tail", 0, {-0.2, 0, 0.1}, {-0.3, 0, -0.4}}};
}

TEST(LimbEnds, LimbsOfTwoBonesOnJointsThatDoNotTurnAreComplete) {
  // Hips and shoulders at the place of their parent are merged with it; feet are then added, so that the limbs keep three sections.
  std::vector<Bone> bones = spine();
  for (const bool fore : {true, false})
    for (const auto& [side, y] : {std::pair(std::string(".L"), 0.2), {".R", -0.2}}) {
      const int girdle = static_cast<int>(bones.size());
      bones.push_back({(fore ? "Shoulder" : "Hip") + side, fore ? 1 : 0, {}, {}});
      bones.push_back({(fore ? "Bicep" : "Thigh") + side, girdle, {0, y, -0.1}, {}});
      bones.push_back({(fore ? "Forearm" : "Shin") + side, girdle + 1, {0, 0, -0.35}, {0, 0, -0.35}});
    }
  std::vector<MeasuredMotion> motions = {moving(bones)};
  for (std::size_t f = 0, n = bones.size(); f < static_cast<std::size_t>(motions[0].frames); ++f)
    for (std::size_t i = 0; i < n; ++i)
      if (bones[i].name.starts_with("Shoulder") || bones[i].name.starts_with("Hip")) motions[0].rotations[f * n + i] = {};
  std::vector<std::string> report;
  const body::Character c = arrange(motions, report);
  EXPECT_EQ(c.plan, body::BodyPlan::four_legs) << c.why_not;
  for (const SkeletonJoint& j : motions[0].skeleton.joints) EXPECT_FALSE(j.name.starts_with("Hip")) << "not merged";
  for (const auto* limbs : {&c.legs, &c.arms})
    for (const body::Limb& l : *limbs) EXPECT_GE(l.end, 0);
}

/// An animal with limbs of three bones. @param end end [m] of the bone of a paw, as a function of: fore limb, left side
template <class End>
std::vector<Bone> animal(const End& end) {
  std::vector<Bone> bones = spine();
  for (const bool fore : {true, false})
    for (const bool left : {true, false}) {
      const std::string name = fore ? "Front" : "Back", side = left ? ".L" : ".R";
      const int upper = static_cast<int>(bones.size());
      bones.push_back({name + "UpperLeg" + side, fore ? 1 : 0, {0, left ? 0.2 : -0.2, -0.1}, {}});
      bones.push_back({name + "LowerLeg" + side, upper, {0, 0, -0.35}, {}});
      bones.push_back({name + "Paw" + side, upper + 1, {0, 0, -0.3}, end(fore, left)});
    }
  return bones;
}

TEST(LimbEnds, EndsFromTheMeshStayOnPawsMuzzleAndTailOfARecognisedAnimal) {
  for (const bool antlers : {false, true}) {
    std::vector<Bone> bones = animal([](bool fore, bool left) { return Vec3{!fore && left ? 0.1 : 0.05, 0, -0.05}; });
    if (antlers) bones[3].end = {0.05, 0, 0.4};
    std::vector<MeasuredMotion> motions = {moving(bones)};
    std::vector<std::string> report;
    ASSERT_EQ(arrange(motions, report, nullptr, true).plan, body::BodyPlan::four_legs);
    EXPECT_TRUE(report.empty());
    for (const SkeletonJoint& j : motions[0].skeleton.joints) {  // the ends of the hind paws differ
      const bool ends = j.name.starts_with("FrontPaw") || j.name == "Tail" || (j.name == "Head" && !antlers);
      EXPECT_EQ(j.end_sites.size(), ends ? 1U : 0U) << j.name;
    }
  }
}

TEST(LimbEnds, EndsFromTheMeshThatLiftTheOtherPairOfPawsAreLeftOut) {
  for (const double length : {0.05, 0.5}) {
    std::vector<MeasuredMotion> motions = {moving(animal([&](bool fore, bool) { return Vec3{0.05, 0, fore ? -0.05 : -length}; }))};
    std::vector<std::string> report;
    ASSERT_EQ(arrange(motions, report, nullptr, true).plan, body::BodyPlan::four_legs);
    for (const SkeletonJoint& j : motions[0].skeleton.joints)
      if (j.name.find("Paw") != std::string::npos) EXPECT_EQ(j.end_sites.size(), length < 0.1 ? 1U : 0U) << j.name;
  }
}

// The root of many rigs of games is on the floor or above the animal.
TEST(HipRoot, IsBetweenTheHips) {
  for (const Vec3& root : {Vec3{0, 0, -0.8}, Vec3{0.2, 0, 1.5}, Vec3{0.1, 0, 0}}) {
    std::vector<Bone> bones = animal([](bool, bool) { return Vec3{0.05, 0, -0.05}; });
    bones[0].offset += root;
    for (Bone& b : bones)
      if (b.parent == 0) b.offset -= root;
    const bool far = norm(root) > 0.5;
    std::vector<MeasuredMotion> motions = {moving(bones)};
    for (std::size_t f = 0; f < 40; ++f) motions[0].rotations[f * bones.size()] = axis_angle({0, 0, 1}, 0.02 * static_cast<double>(f));
    const MeasuredMotion before = motions[0];
    std::vector<std::string> report;
    const body::Character c = arrange(motions, report);
    ASSERT_EQ(c.plan, body::BodyPlan::four_legs) << c.why_not;
    EXPECT_EQ(report.size(), far ? 1U : 0U);
    std::vector<Pose> X, Y;
    for (const int f : {0, 25}) {
      before.calc_joint_poses(f, X);
      motions[0].calc_joint_poses(f, Y);
      EXPECT_NEAR(norm((Y[0].p - (Y[5 + 6].p + Y[5 + 9].p) * 0.5)), far ? 0 : 0.14, far ? 1e-9 : 0.05) << "hips";
      for (std::size_t i = 1; i < X.size(); ++i) EXPECT_NEAR(norm(X[i].p - Y[i].p), 0, 1e-12) << bones[i].name;
      EXPECT_NEAR(norm(rest_positions(before.skeleton)[7] - rest_positions(motions[0].skeleton)[7]), 0, 1e-12);
    }
  }
}

TEST(LimbEnds, AHorseOfTwoBonesForEachLegIsFourLegged) {
  for (const bool names : {true, false}) {
    std::vector<MeasuredMotion> motions = {moving(horse(names))};
    EXPECT_EQ(body::recognise_character(motions[0]).plan, body::BodyPlan::other);
    const MeasuredMotion before = motions[0];
    std::vector<std::string> report;
    const body::Character c = arrange(motions, report, nullptr, true);
    EXPECT_EQ(c.plan, body::BodyPlan::four_legs) << c.why_not;
    EXPECT_NEAR(c.trunk_length, 1.2, 0.05);
    ASSERT_GE(c.legs[0].end, 0);
    // The world positions of the file's joints stay the same.
    std::vector<Pose> X, Y;
    for (const int f : {0, 17, 39}) {
      before.calc_joint_poses(f, X);
      motions[0].calc_joint_poses(f, Y);
      for (std::size_t i = 0; i < before.skeleton.joints.size(); ++i)
        for (std::size_t k = 0; k < motions[0].skeleton.joints.size(); ++k)
          if (before.skeleton.joints[i].name == motions[0].skeleton.joints[k].name) EXPECT_NEAR(norm(X[i].p - Y[k].p), 0, 1e-12);
    }
  }
}

// The rump, which carries the tail, is longer than a leg.
TEST(LimbEnds, ABranchThatCarriesTheTailIsNoLimb) {
  std::vector<Bone> b = {{"hip_holder", -1, {0, 0, 1.2}, {}}, {"body", 0, {0.5, 0, 0.1}, {}},
                         {"neck", 1, {0.25, 0, 0.2}, {}},     {"head", 2, {0.5, 0, 0.5}, {0.4, 0, -0.2}},
                         {"rump", 0, {-0.5, 0, 0.1}, {}},     {"tail", 4, {-0.4, 0, 0.1}, {-0.8, 0, -0.4}}};
  for (const double fore : {1.0, -1.0})
    for (const double side : {1.0, -1.0}) {
      const std::string s = std::string(side > 0 ? "L_" : "R_") + (fore > 0 ? "Front" : "Back");
      const int upper = static_cast<int>(b.size());
      b.push_back({s + "Leg_Upper", 0, {0.6 * fore, 0.2 * side, -0.1}, {}});
      b.push_back({s + "Leg_Lower", upper, {0, 0, -0.5}, {}});
      b.push_back({s + "Hoof", upper + 1, {0, 0, -0.5}, {0, 0, -0.1}});
    }
  std::vector<MeasuredMotion> motions = {moving(b)};
  std::vector<std::string> report;
  EXPECT_EQ(arrange(motions, report, nullptr, true).plan, body::BodyPlan::four_legs);
  std::vector<MeasuredMotion> again = {moving(b)};
  EXPECT_EQ(add_chest(again), (std::vector<std::string>{"L_FrontLeg_Upper", "R_FrontLeg_Upper"}));
}

TEST(LimbEnds, ALimbOfOneBoneIsDividedInItsMiddle) {
  std::vector<MeasuredMotion> motions = {
      moving({{"root", -1, {0, 0, 1}, {}}, {"leg_l", 0, {0, 0.1, 0}, {0, 0, -0.8}}, {"head", 0, {0, 0, 0.3}, {0, 0, 0.2}}})};
  EXPECT_EQ(add_limb_ends(motions), (std::vector<std::string>{"leg_l"}));
  const Skeleton& s = motions[0].skeleton;
  ASSERT_EQ(s.joints.size(), 5u);
  EXPECT_EQ(s.joints[3].name, "leg_l_2");
  EXPECT_NEAR(s.joints[3].offset.z, -0.4, 1e-12);
  EXPECT_EQ(s.joints[4].parent, 3);
  EXPECT_NEAR(s.joints[4].offset.z + s.joints[4].end_sites.at(0).z, -0.4, 1e-12);
}

/// Adds the legs of a person to the hips (bone 0), and arms to bone `chest`. @param shoulder position of the left arm in the chest, m
/// @param arm, forearm, hand vectors along the left arm, m
void add_limbs_of_person(std::vector<Bone>& b, int chest, const Vec3& shoulder, const Vec3& arm, const Vec3& forearm, const Vec3& hand) {
  for (const double side : {1.0, -1.0}) {
    const std::string s = side > 0 ? ".L" : ".R";
    const auto mirrored = [&](const Vec3& v) { return Vec3{v.x, v.y * side, v.z}; };
    const int k = static_cast<int>(b.size());
    b.push_back({"thigh" + s, 0, {0, 0.1 * side, 0}, {}});
    b.push_back({"shin" + s, k, {0.01, 0, -0.45}, {}});
    b.push_back({"foot" + s, k + 1, {-0.01, 0, -0.45}, {0.2, 0, -0.08}});
    b.push_back({"upper_arm" + s, chest, mirrored(shoulder), {}});
    b.push_back({"forearm" + s, k + 3, mirrored(arm), {}});
    b.push_back({"hand" + s, k + 4, mirrored(forearm), mirrored(hand)});
  }
}

TEST(LimbEnds, EndsOfMeshesAreNotUsedForACharacterWithFeet) {
  std::vector<Bone> b = {
      {"hips", -1, {0, 0, 1}, {}}, {"spine", 0, {0, 0, 0.2}, {}}, {"neck", 1, {0, 0, 0.3}, {}}, {"head", 2, {0, 0, 0.1}, {0, 0, 0.2}}};
  add_limbs_of_person(b, 1, {0, 0.2, 0.25}, {0, 0.3, 0}, {0, 0.25, 0}, {0, 0.1, 0});
  std::vector<MeasuredMotion> motions = {moving(b)};
  std::vector<std::string> report;
  EXPECT_EQ(arrange(motions, report, nullptr, true).plan, body::BodyPlan::human);
  for (const SkeletonJoint& j : motions[0].skeleton.joints) EXPECT_TRUE(j.end_sites.empty()) << j.name;
}

/// A dog whose limbs of three bones are attached to different joints of the spine: the left fore limb one joint in front of the right one,
/// the left hind limb one joint behind the right one. @param heads true: with neck and head
std::vector<Bone> uneven_dog(bool names, bool heads) {
  std::vector<Bone> b = {{"body_low", -1, {0, 0, 0.6}, {}}, {"body_mid", 0, {0.3, 0, 0}, {}}, {"body_up", 1, {0.3, 0, 0}, {}}};
  if (heads) {
    b.push_back({"neck", 2, {0.15, 0, 0.1}, {}});
    b.push_back({"head", 3, {0.1, 0, 0.1}, {0.2, 0, 0}});
  }
  const std::vector<Vec3> at = {{0, 0, 0}, {0.3, 0, 0}, {0.6, 0, 0}};  // joints of the spine from the root
  for (const double fore : {1.0, -1.0})
    for (const double side : {1.0, -1.0}) {
      const int spine = fore > 0 ? (side > 0 ? 2 : 1) : (side > 0 ? 0 : 1);
      const Vec3 hip = Vec3{fore > 0 ? 0.5 : 0.05, 0.12 * side, -0.05} - at[static_cast<std::size_t>(spine)];
      const int first = static_cast<int>(b.size());
      const std::string s = side > 0 ? ".L" : ".R";
      const auto name = [&](const char* part) {
        return names ? (fore > 0 ? "leg-front-" : "leg-back-") + std::string(part) + s : "Bone" + std::to_string(b.size());
      };
      b.push_back({name("up"), spine, hip, {}});
      b.push_back({name("mid"), first, {0.03, 0, -0.25}, {}});
      b.push_back({name("low"), first + 1, {-0.03, 0, -0.22}, {0.08, 0, -0.06}});
    }
  return b;
}

TEST(FourLegs, LimbsOfAPairGetTheSameJoint) {
  for (const bool names : {true, false})
    for (const bool heads : {true, false}) {
      SCOPED_TRACE(std::to_string(names) + " " + std::to_string(heads));
      std::vector<MeasuredMotion> motions = {moving(uneven_dog(names, heads))};
      EXPECT_EQ(body::recognise_character(motions[0]).plan, body::BodyPlan::other);
      std::vector<std::string> report;
      const body::Character c = arrange(motions, report);
      ASSERT_EQ(c.plan, body::BodyPlan::four_legs) << c.why_not << (c.decisions.empty() ? "" : c.decisions.back());
      EXPECT_NEAR(c.trunk_length, 0.45, 0.1);
      EXPECT_GE(c.head, 0);
      const Skeleton& s = motions[0].skeleton;
      for (const auto* limbs : {&c.legs, &c.arms}) {
        const auto first = [&](int side) { return s.joints[static_cast<std::size_t>((*limbs)[static_cast<std::size_t>(side)].proximal)]; };
        EXPECT_EQ(first(0).parent, first(1).parent);
      }
      if (names) EXPECT_EQ(s.joints[static_cast<std::size_t>(c.arms[0].proximal)].name, "leg-front-up.L");
    }
}

// Each leg is one bone whose end is known from the mesh, all legs and the tail are children of the body, and there is no head.
// Exporters add a leaf at the end of each bone, which turns with it. Fore and hind limbs are on two branches of the root.
TEST(FourLegs, LeavesAtTheEndsOfBonesAreNoJointsOfALimb) {
  std::vector<Bone> b = {{"All", -1, {0, 0, 0.8}, {}},     {"Body", 0, {-0.5, 0, 0.1}, {}}, {"Head", 1, {1.1, 0, 0.3}, {}},
                         {"Head_end", 2, {0.3, 0, 0}, {}}, {"Tail", 0, {-0.5, 0, 0.1}, {}}, {"Tail_end", 4, {-0.3, 0, 0.1}, {}},
                         {"Holder", 0, {0.4, 0, 0}, {}},   {"Holder2", 0, {-0.4, 0, 0}, {}}};
  for (const double fore : {1.0, -1.0})
    for (const double side : {1.0, -1.0}) {
      const std::string name = std::string(fore > 0 ? "FrontLeg." : "BackLeg.") + (side > 0 ? "L" : "R");
      b.push_back({name, fore > 0 ? 6 : 7, {0.05 * fore, 0.15 * side, -0.1}, {}});
      b.push_back({name + "_end", static_cast<int>(b.size()) - 1, {0.02, 0, -0.7}, {}});
    }
  std::vector<MeasuredMotion> motions = {moving(b)};
  EXPECT_EQ(body::recognise_character(motions[0]).plan, body::BodyPlan::other);
  std::vector<std::string> report;
  const body::Character c = arrange(motions, report);
  ASSERT_EQ(c.plan, body::BodyPlan::four_legs) << c.why_not;
  EXPECT_NEAR(c.trunk_length, 0.9, 0.1);
  EXPECT_NEAR(c.leg_length, 0.7, 0.1);
}

TEST(FourLegs, AHeadlessDogOfOneBoneForEachLegIsFourLegged) {
  for (const bool names : {true, false}) {
    std::vector<Bone> b = {{"root", -1, {}, {}}, {"body", 0, {0, 0, 0.5}, {0.3, 0, 0.2}}, {"tail", 1, {-0.4, 0, 0.1}, {-0.2, 0, 0.2}}};
    for (const double fore : {1.0, -1.0})
      for (const double side : {1.0, -1.0})
        b.push_back({names ? std::string("leg.") + (fore > 0 ? "F" : "B") + (side > 0 ? ".L" : ".R") : "Bone" + std::to_string(b.size()),
                     1,
                     {0.3 * fore, 0.15 * side, -0.1},
                     {0.02, 0, -0.4}});
    std::vector<MeasuredMotion> motions = {moving(b)};
    EXPECT_EQ(body::recognise_character(motions[0]).plan, body::BodyPlan::other);
    std::vector<std::string> report;
    const body::Character c = arrange(motions, report, nullptr, true);
    ASSERT_EQ(c.plan, body::BodyPlan::four_legs) << c.why_not;
    EXPECT_NEAR(c.trunk_length, 0.6, 0.05);
    ASSERT_GE(c.head, 0);
    // The head is in front of the fore limbs.
    std::vector<Pose> X;
    motions[0].calc_joint_poses(0, X);
    const auto x = [&](int i) { return X[static_cast<std::size_t>(i)].p.x; };
    EXPECT_GT(x(c.head), x(c.arms[0].proximal));
    EXPECT_GT(x(c.arms[0].proximal), x(c.legs[0].proximal));
  }
}

/// A nameless creature with legs of 1.7 trunk lengths that has a level trunk (`pitch` 0) or an upright one (`pitch` -pi/2) and arms as
/// long as its legs. @param knee angle by which the shanks of all limbs are bent backwards, rad
std::vector<Bone> long_legged(bool level, double knee) {
  const auto along = [&](double x, double y, double z) { return level ? Vec3{x, y, z} : Vec3{-z, y, x}; };
  std::vector<Bone> b = {{"B0", -1, {0, 0, 1}, {}}, {"B1", 0, along(0.4, 0, 0), {}}, {"B2", 1, along(0.15, 0, 0.1), along(0.2, 0, 0)}};
  for (const int from : {0, 1})
    for (const double side : {1.0, -1.0}) {
      const auto name = [&] { return "B" + std::to_string(b.size()); };
      const int first = static_cast<int>(b.size());
      b.push_back({name(), from, {0, 0.15 * side, 0}, {}});
      b.push_back({name(), first, {0.01, 0, -0.34}, {}});
      b.push_back({name(), first + 1, {-0.34 * std::sin(knee), 0, -0.34 * std::cos(knee)}, {0.06, 0, -0.03}});
    }
  return b;
}

// Nothing but the ground under the limbs distinguishes them: neither names nor tails, and the legs have the length of human legs.
TEST(FourLegs, ALongLeggedAnimalOnFourLimbsIsNoPerson) {
  for (const auto& [level, knee, tail, plan] : {std::tuple{true, 0.1, false, body::BodyPlan::four_legs},
                                                {true, 1.5, false, body::BodyPlan::human},     // crawls
                                                {true, 1.5, true, body::BodyPlan::four_legs},  // lies
                                                {false, 0.1, false, body::BodyPlan::human},
                                                {false, 0.1, true, body::BodyPlan::human}}) {
    std::vector<Bone> bones = long_legged(level, knee);
    if (tail)
      bones.insert(bones.end(), {{"B15", 0, {-0.2, 0, 0.1}, {}}, {"B16", static_cast<int>(bones.size()), {-0.2, 0, 0}, {-0.1, 0, 0}}});
    std::vector<MeasuredMotion> motions = {moving(bones)};
    std::vector<std::string> report;
    const body::Character c = arrange(motions, report);
    EXPECT_EQ(c.plan, plan) << level << " " << knee << " " << tail << " " << c.why_not << (c.decisions.empty() ? "" : c.decisions.back());
  }
}

// A nameless horse without a tail. Its root carries the fore limbs and the neck; a hind limb is one bone that ends in a joint on the
// ground.
TEST(FourLegs, TheJointOfTheHindLimbsBecomesTheRootIfTheHeadIsAtTheRoot) {
  std::vector<Bone> b = {{"j0", -1, {0, 0, 0.75}, {}},
                         {"j1", 0, {0.08, 0, 0.35}, {}},
                         {"j2", 1, {0.28, 0, 0.24}, {}},
                         {"j3", 2, {0.2, 0, -0.2}, {}},
                         {"j4", 0, {-0.82, 0, 0.09}, {}}};
  for (const double side : {1.0, -1.0}) {
    const auto name = [&] { return "j" + std::to_string(b.size()); };
    const int fore = static_cast<int>(b.size());
    b.push_back({name(), 0, {0.01, 0.12 * side, 0}, {}});
    b.push_back({name(), fore, {0, 0.01 * side, -0.3}, {}});
    b.push_back({name(), fore + 1, {0.04, 0, -0.32}, {}});
    b.push_back({name(), fore + 2, {0.05, 0, -0.07}, {}});
    b.push_back({name(), 4, {0, 0.12 * side, 0}, {}});
    b.push_back({name(), fore + 4, {-0.1, 0.03 * side, -0.78}, {}});
  }
  std::vector<MeasuredMotion> motions = {moving(b)};
  EXPECT_EQ(body::recognise_character(motions[0]).plan, body::BodyPlan::other);
  std::vector<std::string> report;
  const body::Character c = arrange(motions, report);
  ASSERT_EQ(c.plan, body::BodyPlan::four_legs) << c.why_not << (c.decisions.empty() ? "" : c.decisions.back());
  EXPECT_NEAR(c.trunk_length, 0.82, 0.05);
  EXPECT_NEAR(c.leg_length, 0.75, 0.1) << "the leg ends on the ground, not a bone's length below it";
  const Skeleton& s = motions[0].skeleton;
  EXPECT_EQ(s.joints[static_cast<std::size_t>(c.pelvis)].name, "j4");
  EXPECT_EQ(s.joints[static_cast<std::size_t>(c.head)].name, "j2") << "the last joint that carries a bone";
}

// An elephant of one bone for each leg. The trunk and the tail reach down to the floor; the trunk is longer than the legs.
TEST(FourLegs, ForeLimbsGetTheJointOfTheTrunkThatMovesWithThem) {
  // All limbs hang on the first joint of the trunk, whose further joints carry a neck without names.
  std::vector<Bone> bones = {{"Body.001", -1, {-0.8, 0, 1.1}, {}},
                             {"Body.002", 0, {0.7, 0, 0}, {}},
                             {"Body.003", 1, {0.7, 0, 0.1}, {}},
                             {"Body.004", 2, {0.5, 0, 0.5}, {0.3, 0, -0.1}},
                             {"Tail", 0, {-0.4, 0, 0.3}, {-0.1, 0, -0.5}}};
  for (const bool fore : {true, false})
    for (const auto& [side, y] : {std::pair(std::string(".L"), 0.25), {".R", -0.25}}) {
      bones.push_back({(fore ? "LegF" : "LegB") + side, 0, {fore ? 1.3 : -0.2, y, -0.2}, {}});
      bones.push_back({(fore ? "LegF.002" : "LegB.002") + side, static_cast<int>(bones.size()) - 1, {0, 0, -0.45}, {0, 0, -0.45}});
    }
  std::vector<MeasuredMotion> motions = {moving(bones)};
  for (std::size_t f = 0, n = bones.size(); f < static_cast<std::size_t>(motions[0].frames); ++f) motions[0].rotations[f * n + 1] = {};
  std::vector<std::string> report;
  const body::Character c = arrange(motions, report);
  ASSERT_EQ(c.plan, body::BodyPlan::four_legs) << c.why_not;
  const auto name = [&](int i) { return motions[0].skeleton.joints[static_cast<std::size_t>(i)].name; };
  EXPECT_EQ(name(c.neck.back()).substr(0, 8), "Body.004") << "the neck of the file, not an added one";
}

TEST(FourLegs, ATrunkThatHangsToTheFloorIsNoLimb) {
  std::vector<Bone> b = {{"body", -1, {0, 0, 1.8}, {}},
                         {"trunk.01", 0, {1.9, 0, -0.15}, {}},
                         {"trunk.02", 1, {0, 0, -0.5}, {}},
                         {"trunk.03", 2, {0, 0, -0.5}, {0, 0, -0.6}},
                         {"tail.01", 0, {-1.2, 0, -0.4}, {-0.3, 0, -0.3}}};
  for (const double fore : {1.0, -1.0})
    for (const double side : {1.0, -1.0})
      b.push_back(
          {std::string("leg.") + (fore > 0 ? "F" : "B") + (side > 0 ? ".L" : ".R"), 0, {0.72 * fore, 0.42 * side, -0.87}, {0, 0, -0.9}});
  for (const double side : {1.0, -1.0}) b.push_back({side > 0 ? "ear.L" : "ear.R", 0, {1.3, 0.43 * side, 0.6}, {-0.9, 0.9 * side, 0}});
  std::vector<MeasuredMotion> motions = {moving(b)};
  std::vector<std::string> report;
  const body::Character c = arrange(motions, report, nullptr, true);
  ASSERT_EQ(c.plan, body::BodyPlan::four_legs) << c.why_not;
  EXPECT_NEAR(c.trunk_length, 1.44, 0.05);
  const auto name = [&](int joint) { return motions[0].skeleton.joints[static_cast<std::size_t>(joint)].name; };
  EXPECT_EQ(name(c.legs[0].proximal), "leg.B.L");
  EXPECT_EQ(name(c.arms[1].proximal), "leg.F.R");
}

// Files of some modellers have a transform at the origin above each limb. A sheep with short legs of two bones.
TEST(FourLegs, LimbsBeginBelowTransformsAtOnePlace) {
  std::vector<Bone> b = {{"sheep", -1, {0, 0, 0.9}, {}}, {"transform1", 0, {0, 0, 0.05}, {}}, {"Head", 1, {0.6, 0, 0.2}, {0.2, 0, 0}}};
  for (const double fore : {1.0, -1.0})
    for (const double side : {1.0, -1.0}) {
      const std::string limb = std::string(side > 0 ? "Left_" : "Right_") + (fore > 0 ? "Front_" : "Back_");
      const int first = static_cast<int>(b.size());
      b.push_back({"transform" + std::to_string(first), 0, {}, {}});
      b.push_back({limb + "Leg", first, {0.4 * fore, 0.2 * side, -0.1}, {}});
      b.push_back({limb + "Knee", first + 1, {0, 0, -0.4}, {0, 0, -0.4}});
    }
  std::vector<MeasuredMotion> motions = {moving(b)};
  std::vector<std::string> report;
  const body::Character c = arrange(motions, report);
  ASSERT_EQ(c.plan, body::BodyPlan::four_legs) << c.why_not << (c.decisions.empty() ? "" : c.decisions.back());
  EXPECT_NEAR(c.trunk_length, 0.8, 0.05);
}

/// An animal whose limbs all have one joint. The tail is named in another language; one paw has a second joint without an end at the same
/// place.
std::vector<Bone> fox() {
  std::vector<Bone> b = {{"Armature", -1, {}, {}},
                         {"Bone", 0, {0.35, 0, 0.4}, {}},
                         {"Bone.001", 1, {0, 0, 0.02}, {0.2, 0, 0.15}},
                         {"tale", 1, {-0.7, 0, 0}, {}},
                         {"tale1", 3, {-0.1, 0, 0.15}, {-0.1, 0, 0.3}}};
  for (const double fore : {1.0, -1.0})
    for (const double side : {1.0, -1.0}) {
      const auto name = [&] { return "Bone.0" + std::to_string(b.size() + 10); };
      const int first = static_cast<int>(b.size());
      b.push_back({name(), 1, {fore > 0 ? 0 : -0.65, 0.01 * side, 0}, {}});
      b.push_back({name(), first, {0.03, 0.12 * side, -0.05}, {}});
      b.push_back({name(), first + 1, {-0.02, 0.02 * side, -0.17}, {0.02, 0, -0.15}});
      if (fore < 0 && side < 0) b.push_back({name(), first + 1, {-0.02, 0.02 * side, -0.17}, {}});
    }
  return b;
}

TEST(FourLegs, APawOfTwoJointsAtOnePlaceIsOneLimb) {
  std::vector<MeasuredMotion> motions = {moving(fox())};
  for (Quat& q : motions[0].rotations)
    q = axis_angle({0, 1, 0}, 0.5 * std::asin(q.y));  // a quarter of the swing: all paws touch the ground
  EXPECT_EQ(body::recognise_character(motions[0]).plan, body::BodyPlan::other);
  std::vector<std::string> report;
  const body::Character c = arrange(motions, report);
  ASSERT_EQ(c.plan, body::BodyPlan::four_legs) << c.why_not << (c.decisions.empty() ? "" : c.decisions.back());
  EXPECT_NEAR(c.trunk_length, 0.65, 0.1);
  std::vector<Pose> X;
  motions[0].calc_joint_poses(0, X);
  EXPECT_GT(X[static_cast<std::size_t>(c.arms[0].proximal)].p.x, X[static_cast<std::size_t>(c.legs[0].proximal)].p.x);
}

// Half a stride: the left fore limb and the right hind limb are behind, the others in front.
TEST(FourLegs, LimbsAreAPairAlsoIfOneIsInFront) {
  const std::vector<Bone> b = fox();
  std::vector<MeasuredMotion> motions = {moving(b)};
  std::vector<int> limbs;  // first bones; left fore, right fore, left hind, right hind
  for (std::size_t i = 5; i < b.size(); ++i)
    if (b[i].parent == 1) limbs.push_back(static_cast<int>(i));
  ASSERT_EQ(limbs.size(), 4U);
  for (std::size_t f = 0; f < static_cast<std::size_t>(motions[0].frames); ++f)
    for (std::size_t i = 0; i < b.size(); ++i) {
      const auto limb = std::ranges::find(limbs, b[i].parent);
      const bool behind = limb == limbs.begin() || limb == limbs.end() - 1;
      const double angle = limb == limbs.end() ? 0 : (behind ? 0.6 : -0.6) + 0.1 * std::sin(0.3 * static_cast<double>(f));
      motions[0].rotations[f * b.size() + i] = axis_angle({0, 1, 0}, angle);
    }
  std::vector<std::string> report;
  const body::Character c = arrange(motions, report);
  ASSERT_EQ(c.plan, body::BodyPlan::four_legs) << c.why_not << (c.decisions.empty() ? "" : c.decisions.back());
  EXPECT_NEAR(c.trunk_length, 0.65, 0.1);
}

// Parts have the names of human ones, and the legs the length of human legs. Names of front and rear, or a tail, state the animal.
TEST(FourLegs, ALongLeggedAnimalWithHumanNamesIsNoPerson) {
  for (const bool tail : {true, false}) {
    std::vector<Bone> b = long_legged(true, 0.1);
    b[2].name = "Head";
    const char* parts[] = {"Leg1", "Leg2", "Foot"};
    for (std::size_t i = 3; i < b.size(); ++i) {
      const bool hind = i < 9;
      const std::string side = (i - 3) / 3 % 2 == 0 ? "_L" : "_R", part = parts[(i - 3) % 3];
      b[i].name = tail ? (hind ? "Thigh,Calf,Foot" : "Arm,Forearm,Hand") : (hind ? "Rear" : "Front") + part + side;
      if (!tail) continue;
      std::string list = b[i].name;
      for (std::size_t k = 0; k < (i - 3) % 3; ++k) list = list.substr(list.find(',') + 1);
      b[i].name = list.substr(0, list.find(',')) + side;
    }
    if (tail) b.push_back({"Tail", 0, {-0.1, 0, 0.05}, {-0.2, 0, -0.1}});
    std::vector<MeasuredMotion> motions = {moving(b)};
    std::vector<std::string> report;
    const body::Character c = arrange(motions, report);
    EXPECT_EQ(c.plan, body::BodyPlan::four_legs) << tail << " " << c.why_not << (c.decisions.empty() ? "" : c.decisions.back());
  }
}

TEST(FourLegs, AHeadlessPersonIsNotFourLegged) {
  std::vector<Bone> b = {{"hips", -1, {0, 0, 1}, {}}, {"spine", 0, {0, 0, 0.25}, {}}, {"chest", 1, {0, 0, 0.2}, {}}};
  add_limbs_of_person(b, 2, {0, 0.2, 0.05}, {0, 0, -0.3}, {0, 0, -0.25}, {0, 0, -0.1});
  std::vector<MeasuredMotion> motions = {moving(b)};
  std::vector<std::string> report;
  EXPECT_NE(arrange(motions, report).plan, body::BodyPlan::four_legs);
}

/// An animal of blocks: all legs at one joint, and one bone from the rump to the neck, or to the head.
TEST(FourLegs, ATrunkBoneAtTheRumpCarriesNoForeLimbs) {
  for (const bool neck : {true, false}) {
    std::vector<Bone> b = {{"All", -1, {0.04, 0, 0.35}, {}}, {"Body", 0, {-0.7, 0, 0.38}, {}}};
    if (neck) b.push_back({"Neck", 1, {1.08, 0, 0}, {}});
    b.push_back({"Head", neck ? 2 : 1, neck ? Vec3{0, 0, 0.5} : Vec3{1, 0, 0.5}, {0, 0, 0.8}});
    for (const double fore : {1.0, -1.0})
      for (const double side : {1.0, -1.0})
        b.push_back({std::string(fore > 0 ? "Front" : "Back") + "Leg" + (side > 0 ? ".L" : ".R"),
                     0,
                     {fore > 0 ? 0.5 : -0.6, 0.25 * side, 0.1},
                     {0, 0, -0.44}});
    std::vector<MeasuredMotion> motions = {moving(b)};
    for (std::size_t i = 0; i < motions[0].rotations.size(); ++i)
      if (b[i % b.size()].name == "Body") motions[0].rotations[i] = {};
    std::vector<std::string> report;
    const body::Character c = arrange(motions, report);
    ASSERT_EQ(c.plan, body::BodyPlan::four_legs) << c.why_not;
    ASSERT_GE(c.head, 0);
    EXPECT_EQ(motions[0].skeleton.joints[static_cast<std::size_t>(c.head)].name, "Head");
  }
}

/// A person of one bone for each limb. All limbs, the trunk and the head (if there is one) have one common joint, as in rigs of blocks.
std::vector<Bone> block_person(bool with_head) {
  std::vector<Bone> b = {{"root", -1, {0, 0, 0.75}, {}}, {"Body", 0, {0, 0, 0}, {0, 0, 0.7}}};
  if (with_head) b.push_back({"Head", 0, {0, 0, 0.75}, {0, 0, 0.45}});
  for (const double side : {1.0, -1.0}) {
    const std::string name = side > 0 ? "Left" : "Right";
    b.push_back({name + "Arm", 0, {0, 0.3 * side, 0.65}, {0, 0, -0.7}});
    b.push_back({name + "Leg", 0, {0, 0.1 * side, 0}, {0, 0, -0.73}});
  }
  return b;
}

TEST(BlockPersons, LimbsAtOneJointAreIdentifiedByTheirNames) {
  std::vector<MeasuredMotion> motions = {moving(block_person(true))};
  std::vector<std::string> report;
  const body::Character c = arrange(motions, report);
  ASSERT_EQ(c.plan, body::BodyPlan::human) << c.why_not;
  const auto name = [&](int i) { return i < 0 ? std::string("none") : motions[0].skeleton.joints[static_cast<std::size_t>(i)].name; };
  EXPECT_EQ(name(c.arms[0].proximal), "LeftArm");
  EXPECT_EQ(name(c.legs[1].proximal), "RightLeg");
  EXPECT_EQ(name(c.head), "Head");
  EXPECT_TRUE(c.tail.empty()) << name(c.tail[0]);
}

TEST(BlockPersons, APersonWithoutAJointForTheHeadGetsOneAboveTheShoulders) {
  const MeasuredMotion before = moving(block_person(false));
  std::vector<MeasuredMotion> motions = {before};
  std::vector<std::string> report;
  const body::Character c = arrange(motions, report);
  ASSERT_EQ(c.plan, body::BodyPlan::human) << c.why_not;
  ASSERT_GE(c.head, 0);
  EXPECT_TRUE(std::ranges::any_of(report, [](const std::string& r) { return r.find("No joint carries the head") != std::string::npos; }));
  std::vector<Pose> X;
  motions[0].calc_joint_poses(7, X);
  // The shoulders are 0.65 m above the hips; the head is 0.35 trunk lengths above them.
  const Vec3 head = X[static_cast<std::size_t>(c.head)].p;
  EXPECT_LT(norm(head - Vec3{0, 0, 0.75 + 1.35 * 0.65}), 0.01) << head.x << " " << head.y << " " << head.z;
}

}  // namespace
}  // namespace ugoki::intake
