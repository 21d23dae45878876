// Tests of the recognition of characters: names of many conventions, body parts, body plans, canonical rest poses.
#include "ugoki/body/recognise.h"

#include <gtest/gtest.h>

#include "measured_files.h"
#include "ugoki/body/joint_names.h"

namespace ugoki::body {
namespace {

TEST(JointNames, PartsAndSidesOfManyConventions) {
  struct Case {
    std::vector<std::string> names;
    std::vector<Part> parts;
    std::vector<int> sides;
  };
  const std::vector<Part> leg = {Part::pelvis, Part::thigh, Part::shank, Part::foot, Part::upper_arm, Part::forearm, Part::hand};
  const std::vector<int> left = {0, 1, 1, 1, -1, -1, -1};
  for (const Case& c : std::vector<Case>{
           {{"mixamorig:Hips", "mixamorig:LeftUpLeg", "mixamorig:LeftLeg", "mixamorig:LeftFoot", "mixamorig:RightArm",
             "mixamorig:RightForeArm", "mixamorig:RightHand"},
            leg,
            left},
           {{"Bip01 Pelvis", "Bip01 L Thigh", "Bip01 L Calf", "Bip01 L Foot", "Bip01 R UpperArm", "Bip01 R Forearm", "Bip01 R Hand"},
            leg,
            left},
           {{"CC_Base_Hip", "CC_Base_L_Thigh", "CC_Base_L_Calf", "CC_Base_L_Foot", "CC_Base_R_Upperarm", "CC_Base_R_Forearm",
             "CC_Base_R_Hand"},
            leg,
            left},
           {{"pelvis", "thigh_l", "calf_l", "foot_l", "upperarm_r", "lowerarm_r", "hand_r"}, leg, left},
           {{"J_Bip_C_Hips", "J_Bip_L_UpperLeg", "J_Bip_L_LowerLeg", "J_Bip_L_Foot", "J_Bip_R_UpperArm", "J_Bip_R_LowerArm",
             "J_Bip_R_Hand"},
            leg,
            left},
           {{"hip", "LThigh", "LShin", "LFoot", "rShldr", "rForeArm", "rHand"}, leg, left},
           {{"root_pelvis", "lfemur", "ltibia", "lfoot", "rhumerus", "rradius", "rhand"}, leg, left},
           {{"Becken", "Oberschenkel_links", "Unterschenkel_links", "Fuss_links", "Oberarm_rechts", "Unterarm_rechts", "Hand_rechts"},
            leg,
            left}}) {
    const std::vector<NameEvidence> evidence = read_joint_names(c.names);
    for (std::size_t i = 0; i < c.names.size(); ++i) {
      EXPECT_TRUE(evidence[i].part == c.parts[i] || evidence[i].second == c.parts[i]) << c.names[i];
      EXPECT_EQ(evidence[i].side, c.sides[i]) << c.names[i];
      EXPECT_FALSE(evidence[i].helper) << c.names[i];
    }
  }
  for (const char* name :
       {"Bip01 HeadNub", "LeftForeArmTwist", "CC_Base_L_ThighTwist01", "Camera", "LeftToe_End", "Hair_03", "eye.L", "Controller"}) {
    const std::vector<std::string> one = {name};
    EXPECT_TRUE(read_joint_names(one)[0].helper) << name;
  }
}

TEST(JointNames, NamesDistinguishHindLimbsAndControls) {
  const std::vector<std::string> names = {"BackLeg.L",   "FrontLeg.L",   "BackShoulder.R", "Back",         "LeftForeArm",
                                          "IKBackLeg.L", "PoleTarget.L", "ForwardLeg.R",   "BackwardLeg.R"};
  const std::vector<NameEvidence> e = read_joint_names(names);
  EXPECT_TRUE(e[0].hind && !e[0].fore && e[0].part == Part::shank);
  EXPECT_TRUE(e[1].fore && !e[1].hind && e[1].part == Part::forearm);
  EXPECT_TRUE(e[2].hind && e[2].part == Part::other) << "the shoulder of a hind leg is no shoulder";
  EXPECT_TRUE(!e[3].hind && e[3].part == Part::trunk);
  EXPECT_TRUE(!e[4].fore && e[4].part == Part::forearm) << "a forearm is no fore limb";
  EXPECT_TRUE(e[5].helper && e[5].control && e[5].hind);
  EXPECT_TRUE(e[6].helper && !e[6].control) << "a pole target is no part of a limb";
  EXPECT_TRUE(e[7].fore && e[8].hind);
  const std::vector<std::string> letters = {"leg.F.L", "leg.B.R", "finger.F.L", "legB", "spine"};
  const std::vector<NameEvidence> f = read_joint_names(letters);
  EXPECT_TRUE(f[0].fore && f[0].side > 0 && f[0].part == Part::forearm);
  EXPECT_TRUE(f[1].hind && f[1].side < 0 && f[1].part == Part::shank);
  EXPECT_TRUE(!f[2].fore && f[3].hind);
  const std::vector<std::string> corners = {"LegFLAnkle", "LegBR1", "spine"};
  const std::vector<NameEvidence> c = read_joint_names(corners);
  EXPECT_TRUE(c[0].fore && c[0].side > 0 && c[1].hind && c[1].side < 0);
  const std::vector<std::string> joined = {"frontleg0", "R_backleg", "hindpaw", "legfront", "forefoot", "backbone", "forearm"};
  const std::vector<NameEvidence> j = read_joint_names(joined);
  EXPECT_TRUE(j[0].fore && !j[0].hind && j[0].part == Part::forearm);
  EXPECT_TRUE(j[1].hind && !j[1].fore && j[1].part == Part::shank && j[1].side < 0);
  EXPECT_TRUE(j[2].hind && j[3].fore);
  EXPECT_TRUE(!j[4].fore && !j[5].hind && !j[6].fore) << "parts of a person";
}

TEST(Recognise, ThePartsDoNotDependOnTheRestPose) {
  const MeasuredMotion motion = testing::made_character(60);
  const Character character = recognise_character(motion);
  ASSERT_EQ(character.plan, BodyPlan::human) << character.why_not;
  std::vector<Mat3> turns;
  for (int i = 0; i < motion.joint_count(); ++i) turns.push_back(rotation_about(normalized(Vec3{1.0 * i, 2, 3.0 - i}), 0.7 * i));
  const MeasuredMotion other = with_rest_pose(motion, turns);
  const Character again = recognise_character(other);
  ASSERT_EQ(again.plan, BodyPlan::human) << again.why_not;
  for (std::size_t i = 0; i < character.parts.size(); ++i) {
    EXPECT_EQ(character.parts[i].part, again.parts[i].part) << motion.skeleton.joints[i].name;
    EXPECT_EQ(character.parts[i].side, again.parts[i].side) << motion.skeleton.joints[i].name;
  }
  // The canonical rest positions agree too.
  const auto a = rest_positions(with_rest_pose(motion, canonical_turns(motion, character)).skeleton);
  const auto b = rest_positions(with_rest_pose(other, canonical_turns(other, again)).skeleton);
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_LT(norm(a[i] - b[i]), 1e-9) << motion.skeleton.joints[i].name;
}

TEST(Recognise, AnotherRestPoseKeepsTheWorldPositions) {
  const MeasuredMotion motion = testing::made_character(20);
  std::vector<Mat3> turns;
  for (int i = 0; i < motion.joint_count(); ++i) turns.push_back(rotation_about({0, 1, 0}, 0.3 * i) * rotation_about({1, 0, 0}, 0.2 * i));
  const MeasuredMotion other = with_rest_pose(motion, turns);
  std::vector<Pose> X, Y;
  for (int f = 0; f < motion.frames; ++f) {
    motion.calc_joint_poses(f, X);
    other.calc_joint_poses(f, Y);
    for (std::size_t i = 0; i < X.size(); ++i) EXPECT_LT(norm(X[i].p - Y[i].p), 1e-12);
  }
}

TEST(Recognise, TheCanonicalPoseOfAHumanIsATPose) {
  const MeasuredMotion motion = testing::made_character(60);
  const Character f = recognise_character(motion);
  const auto p = rest_positions(with_rest_pose(motion, canonical_turns(motion, f)).skeleton);
  const auto direction = [&](int from, int to) { return normalized(p[static_cast<std::size_t>(to)] - p[static_cast<std::size_t>(from)]); };
  EXPECT_NEAR(direction(f.legs[0].proximal, f.legs[0].end).z, -1, 1e-9);
  EXPECT_NEAR(direction(f.legs[1].distal, f.legs[1].end).z, -1, 1e-9);
  EXPECT_NEAR(direction(f.arms[0].proximal, f.arms[0].end).y, 1, 1e-9);
  EXPECT_NEAR(direction(f.arms[1].proximal, f.arms[1].end).y, -1, 1e-9);
  EXPECT_GT(direction(f.legs[0].end, f.legs[0].tip).x, 0.8);
}

TEST(Recognise, NoFramesAndNoJointsAreNoCharacter) {
  EXPECT_EQ(recognise_character({}).plan, BodyPlan::other);
  MeasuredMotion still = testing::made_character(5);
  still.frames = 0;
  still.translations.clear();
  still.rotations.clear();
  EXPECT_EQ(recognise_character(still).plan, BodyPlan::other);
}

// A joint with N children has N^2 / 2 pairs of similar branches. All pairs of pairs of this star would take more than an hour.
TEST(Recognise, StarsWithThousandsOfBranchesAreRecognisedInBoundedWork) {
  MeasuredMotion star;
  star.rate = 30;
  star.frames = 1;
  star.skeleton.joints.emplace_back();
  star.skeleton.joints[0].name = "hub";
  for (int i = 0; i < 3000; ++i) {
    SkeletonJoint ray;
    ray.name = "ray" + std::to_string(i);
    ray.parent = 0;
    ray.offset = {ugoki::sin_cos(0.002 * i).cos, ugoki::sin_cos(0.002 * i).sin, 1};
    star.skeleton.joints.push_back(ray);
  }
  for (const SkeletonJoint& joint : star.skeleton.joints) star.translations.push_back(joint.offset);
  star.rotations.assign(star.skeleton.joints.size(), {});
  EXPECT_NE(recognise_character(star).plan, BodyPlan::human);
}

/// Adds all frames of a motion: each joint but the root swings about y. @param angle rad @param per_frame, per_joint rad of the phase
void swing_joints(MeasuredMotion& m, double angle, double per_frame, double per_joint) {
  for (int f = 0; f < m.frames; ++f)
    for (int i = 0; i < m.joint_count(); ++i) {
      m.translations.push_back(m.skeleton.joints[static_cast<std::size_t>(i)].offset);
      m.rotations.push_back(i == 0 ? Quat{} : axis_angle({0, 1, 0}, angle * std::sin(per_frame * f + per_joint * i)));
    }
}

/// An animal with four legs of four joints each, a neck, a head, and a pair of chains of four joints at the pelvis. All joints swing.
/// @param pair name of the pair's joints
MeasuredMotion animal_with_pair(const std::string& pair) {
  MeasuredMotion m;
  m.rate = 30;
  m.frames = 40;
  const auto add = [&](const std::string& name, int parent, const Vec3& offset) {
    SkeletonJoint j;
    j.name = name;
    j.parent = parent;
    j.offset = offset;
    j.translates = parent < 0;
    m.skeleton.joints.push_back(std::move(j));
    return m.joint_count() - 1;
  };
  const int pelvis = add("SpineBase", -1, {0, 0, 0.5});
  const int chest = add("Spine2", add("Spine1", pelvis, {0.25, 0, 0}), {0.25, 0, 0});
  const int head = add("Head", add("Neck", chest, {0.1, 0, 0.1}), {0.12, 0, 0.12});
  m.skeleton.joints[static_cast<std::size_t>(head)].end_sites.push_back({0.15, 0, 0});
  for (const double side : {1.0, -1.0}) {
    const std::string mark = side > 0 ? ".L" : ".R";
    for (const bool fore : {false, true}) {
      const std::string leg = fore ? "FrontLeg" : "BackLeg";
      int i = add(leg + "Base" + mark, fore ? chest : pelvis, {0, 0.06 * side, 0});
      const Vec3 bones[] = {{0.02, 0.02 * side, -0.05}, {fore ? -0.05 : 0.05, 0, -0.2}, {fore ? 0.05 : -0.05, 0, -0.17}, {0.06, 0, -0.08}};
      for (int k = 0; k < 4; ++k) i = add(leg + std::to_string(k + 1) + mark, i, bones[k]);
    }
    int i = pelvis;
    for (int k = 0; k < 4; ++k) i = add(pair + std::to_string(k + 1) + mark, i, {-0.1, 0.03 * side, -0.05});
  }
  swing_joints(m, 0.2, 0.3, 0.9);
  return m;
}

TEST(Recognise, TwoTailsAreNoLegs) {
  const Character tails = recognise_character(animal_with_pair("Tail"));
  EXPECT_EQ(tails.plan, BodyPlan::four_legs) << tails.why_not;
  EXPECT_FALSE(tails.tail.empty());
  const Character six_legs = recognise_character(animal_with_pair("MiddleLeg"));
  EXPECT_EQ(six_legs.plan, BodyPlan::other);
  EXPECT_EQ(six_legs.why_not, "it has 6 limbs.");
}

TEST(Recognise, BonesThatHangAboveTheGroundAreNoLegs) {
  const auto with_bones_down = [](double z) {  // m, height of each of the four bones of the pair
    MeasuredMotion m = animal_with_pair("Wool");
    for (SkeletonJoint& j : m.skeleton.joints)
      if (j.name.starts_with("Wool")) j.offset.z = z;
    for (std::size_t i = 0; i < m.translations.size(); ++i) m.translations[i] = m.skeleton.joints[i % m.skeleton.joints.size()].offset;
    return m;
  };
  const Character fur = recognise_character(with_bones_down(0));
  EXPECT_EQ(fur.plan, BodyPlan::four_legs) << fur.why_not;
  EXPECT_EQ(recognise_character(with_bones_down(-0.125)).plan, BodyPlan::other);
}

/// A level animal whose trunk begins at the joint of its hind limbs: a long tail points up and back, a long neck forwards; names state
/// nothing.
MeasuredMotion animal_with_raised_tail() {
  MeasuredMotion m;
  m.rate = 24;
  m.frames = 7;
  const auto add = [&](int parent, const Vec3& offset) {
    SkeletonJoint j;
    j.name = "Z" + std::to_string(m.joint_count());
    j.parent = parent;
    j.offset = offset;
    j.translates = parent < 0;
    m.skeleton.joints.push_back(std::move(j));
    return m.joint_count() - 1;
  };
  const int hips = add(-1, {0, 0, 0.156});
  add(add(hips, {-0.06, 0, 0.024}), {-0.018, 0, 0.016});  // tail
  const int chest = add(hips, {0.154, 0, -0.008});
  add(add(chest, {0.089, 0, 0.014}), {0.142, 0, 0.046});  // neck and head
  for (const double side : {1.0, -1.0})
    for (const int from : {hips, chest}) {
      const bool hind = from == hips;
      int i = add(from, {0.003, 0.03 * side, -0.018});
      const Vec3 bones[] = {{hind ? 0.004 : 0.016, 0, hind ? -0.089 : -0.083}, {0.014, 0, -0.021}, {-0.008, 0, -0.027}};
      for (const Vec3& bone : bones) i = add(i, bone);
    }
  swing_joints(m, 0.1, 0.9, 2.1);
  return m;
}

TEST(Recognise, FrontLimbsHangBelowTheHindLimbsInTheTree) {
  const Character animal = recognise_character(animal_with_raised_tail());
  EXPECT_EQ(animal.plan, BodyPlan::four_legs) << animal.why_not;
  EXPECT_EQ(animal.pelvis, 0);
}

TEST(Mapping, TheRecognisedMappingGivesTheSameCharacter) {
  const MeasuredMotion motion = testing::made_character(60);
  const Character before = recognise_character(motion);
  const AnatomyMapping mapping = mapping_of(before, motion.skeleton);
  ASSERT_EQ(mapping.limbs.size(), 5u);
  for (const LimbMapping& l : mapping.limbs) {
    EXPECT_GT(l.confidence, 0.8) << l.name;
    EXPECT_LE(l.confidence, 1) << l.name;
  }
  EXPECT_TRUE(check_mapping(mapping, motion.skeleton, "mapping").empty());
  const Character after = recognise_character(motion, &mapping);
  EXPECT_TRUE(after.corrected);
  EXPECT_EQ(after.plan, before.plan) << after.why_not;
  for (std::size_t i = 0; i < before.parts.size(); ++i) {
    EXPECT_EQ(after.parts[i].part, before.parts[i].part) << motion.skeleton.joints[i].name;
    EXPECT_EQ(after.parts[i].side, before.parts[i].side) << motion.skeleton.joints[i].name;
  }
}

TEST(Mapping, ACorrectionExchangesLeftAndRight) {
  const MeasuredMotion motion = testing::made_character(60);
  AnatomyMapping mapping = mapping_of(recognise_character(motion), motion.skeleton);
  for (LimbMapping& l : mapping.limbs) {
    if (l.name.starts_with("left"))
      l.name.replace(0, 4, "right");
    else if (l.name.starts_with("right"))
      l.name.replace(0, 5, "left");
  }
  const Character character = recognise_character(motion, &mapping);
  ASSERT_EQ(character.plan, BodyPlan::human) << character.why_not;
  EXPECT_EQ(motion.skeleton.joints[static_cast<std::size_t>(character.legs[0].proximal)].name, "RightUpLeg");
  EXPECT_EQ(motion.skeleton.joints[static_cast<std::size_t>(character.arms[1].end)].name, "LeftHand");
}

TEST(Mapping, ThePlanCanBeCorrected) {
  const MeasuredMotion motion = testing::made_character(60);
  AnatomyMapping mapping;
  for (const auto& [name, plan] : {std::pair{"other", BodyPlan::other}, {"four legs", BodyPlan::four_legs}, {"human", BodyPlan::human}}) {
    mapping.plan = name;
    EXPECT_EQ(recognise_character(motion, &mapping).plan, plan);
  }
}

TEST(Mapping, WrongCorrectionsAreReported) {
  const MeasuredMotion motion = testing::made_character(60);
  const AnatomyMapping good = mapping_of(recognise_character(motion), motion.skeleton);
  AnatomyMapping wrong = good;
  wrong.limbs[0].sections[0].joint = "Nothing";
  wrong.limbs[1].sections[0].section = "wing";
  wrong.limbs[2].name = "third leg";
  wrong.plan = "centaur";
  EXPECT_EQ(check_mapping(wrong, motion.skeleton, "m").problems.size(), 4u);
  // A shank above its thigh is no leg.
  wrong = good;
  std::swap(wrong.limbs[0].sections[0].joint, wrong.limbs[0].sections[1].joint);
  const Character character = recognise_character(motion, &wrong);
  EXPECT_EQ(character.plan, BodyPlan::other);
  EXPECT_NE(character.why_not.find("do not follow each other"), std::string::npos) << character.why_not;
}

}  // namespace
}  // namespace ugoki::body
