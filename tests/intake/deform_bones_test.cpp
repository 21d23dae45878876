// Rigs of Rigify: the bones that deform the mesh hang on mechanisms.
#include "ugoki/intake/deform_bones.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "ugoki/intake/arrange.h"
#include "ugoki/intake/tree_edit.h"

namespace ugoki::intake {
namespace {

struct Bone {
  std::string name;
  int parent;
  Vec3 offset;
};

/// A motion in which the joints of the limbs swing about y, and all others follow the root.
MeasuredMotion moving(const std::vector<Bone>& bones) {
  MeasuredMotion m;
  m.rate = 30;
  m.frames = 40;
  for (const Bone& b : bones) {
    SkeletonJoint j;
    j.name = b.name;
    j.parent = b.parent;
    j.offset = b.offset;
    j.translates = b.parent < 0;
    m.skeleton.joints.push_back(std::move(j));
  }
  for (int f = 0; f < m.frames; ++f)
    for (std::size_t i = 0; i < bones.size(); ++i) {
      const bool limb =
          bones[i].name.starts_with("DEF-front") || bones[i].name.starts_with("DEF-thigh") || bones[i].name.starts_with("DEF-sh");
      m.translations.push_back(bones[i].offset);
      m.rotations.push_back(limb ? axis_angle({0, 1, 0}, 0.2 * std::sin(0.3 * f + 0.9 * static_cast<double>(i))) : Quat{});
    }
  return m;
}

/// A dog whose spine hangs on the root, and whose limbs hang on copies of bones of the spine. The controls of its tail have the opposite
/// order of the bones.
std::vector<Bone> rig() {
  std::vector<Bone> b = {{"rig", -1, {}},                        // 0
                         {"root", 0, {}},                        // 1
                         {"DEF-spine.004", 1, {-0.3, 0, 0.5}},   // 2
                         {"DEF-spine.005", 2, {0.2, 0, 0}},      // 3
                         {"DEF-spine.006", 3, {0.2, 0, 0}},      // 4
                         {"DEF-spine.007", 4, {0.15, 0, 0.1}},   // 5: neck
                         {"DEF-spine.008", 5, {0.12, 0, 0.08}},  // 6: head
                         {"DEF-spine.009", 6, {0.15, 0, 0}},     // 7
                         {"MCH-torso.parent", 1, {0, 0, 0.6}},   // 8
                         {"torso", 8, {0, 0, -0.1}},             // 9
                         {"spine_fk.006", 9, {0.1, 0, 0}},       // 10
                         {"ORG-spine.006", 10, {}},              // 11
                         {"ORG-spine.004", 9, {-0.3, 0, 0}},     // 12
                         {"spine.003", 12, {}},                  // 13
                         {"spine.002", 13, {-0.1, 0, 0}},        // 14
                         {"tweak_spine.002", 14, {-0.1, 0, 0}},  // 15
                         {"DEF-spine.002", 15, {}},              // 16: end of the tail
                         {"DEF-spine.003", 16, {0.1, 0, 0}}};    // 17
  for (const auto& [on, x, names] : {std::tuple{12, 0.0, std::array{"DEF-thigh", "DEF-shin", "DEF-foot", "DEF-toe"}},
                                     {11, 0.0, std::array{"DEF-front_thigh", "DEF-front_shin", "DEF-front_foot", "DEF-front_toe"}}})
    for (const double side : {1.0, -1.0}) {
      int parent = on;
      Vec3 offset{x, 0.08 * side, -0.02};
      for (const char* name : names) {
        b.push_back({std::string(name) + (side > 0 ? ".L" : ".R"), parent, offset});
        parent = static_cast<int>(b.size()) - 1;
        offset = std::string(name).ends_with("foot") ? Vec3{0.05, 0, -0.05} : Vec3{0.02, 0, -0.2};
      }
    }
  return b;
}

TEST(DeformBones, EachIsAttachedToTheNextOfThem) {
  MeasuredMotion m = moving(rig());
  std::map<std::string, Vec3> before;
  const auto poses = [](const MeasuredMotion& motion) {
    std::map<std::string, Vec3> out;
    const auto world = world_of(motion);
    for (std::size_t i = 0; i < motion.skeleton.joints.size(); ++i) out[motion.skeleton.joints[i].name] = world[17][i].p;
    return out;
  };
  before = poses(m);
  ASSERT_TRUE(keep_deform_bones({&m, 1}));
  std::map<std::string, std::string> parents;
  for (const SkeletonJoint& j : m.skeleton.joints)
    parents[j.name] = j.parent < 0 ? "" : m.skeleton.joints[static_cast<std::size_t>(j.parent)].name;
  EXPECT_EQ(parents.size(), 24u);
  EXPECT_EQ(parents.at("DEF-spine.004"), "");
  EXPECT_EQ(parents.at("DEF-spine.005"), "DEF-spine.004");
  EXPECT_EQ(parents.at("DEF-thigh.L"), "DEF-spine.004");
  EXPECT_EQ(parents.at("DEF-front_thigh.R"), "DEF-spine.006");
  EXPECT_EQ(parents.at("DEF-shin.R"), "DEF-thigh.R");
  EXPECT_EQ(parents.at("DEF-spine.003"), "DEF-spine.002");
  EXPECT_EQ(parents.at("DEF-spine.002"), "DEF-spine.004") << "not its own child";
  for (const auto& [name, p] : poses(m)) EXPECT_LT(norm(p - before.at(name)), 1e-12) << name;
}

TEST(DeformBones, ADogOnMechanismsIsFourLegged) {
  std::vector<MeasuredMotion> motions = {moving(rig())};
  ASSERT_EQ(body::recognise_character(motions[0]).plan, body::BodyPlan::other);
  std::vector<std::string> report;
  const body::Character c = arrange(motions, report);
  ASSERT_EQ(c.plan, body::BodyPlan::four_legs) << c.why_not;
  EXPECT_NEAR(c.trunk_length, 0.4, 0.02);
  EXPECT_EQ(motions[0].skeleton.joints[static_cast<std::size_t>(c.legs[0].proximal)].name, "DEF-thigh.L");
}

TEST(DeformBones, AnAnimalThatIsRecognisedByItsMechanismsGetsTheDeformingBones) {
  // Each bone that deforms the mesh hangs on a bone of the mechanism, whose names state an animal.
  const std::vector<Bone> mechanism = {{"spine", -1, {0, 0, 0.6}},    {"spine.001", 0, {0.3, 0, 0}},   {"spine.002", 1, {0.2, 0, 0}},
                                       {"neck", 2, {0.15, 0, 0.1}},   {"head", 3, {0.15, 0, 0.1}},     {"head_top", 4, {0.15, 0, 0}},
                                       {"tail", 0, {-0.15, 0, 0.05}}, {"tail.001", 6, {-0.2, 0, -0.1}}};
  std::vector<Bone> all = mechanism;
  for (const auto& [on, names] :
       {std::pair{0, std::array{"thigh", "shin", "foot", "toe"}}, {2, std::array{"front_thigh", "front_shin", "front_foot", "front_toe"}}})
    for (const double side : {1.0, -1.0}) {
      int parent = on;
      Vec3 offset{0, 0.08 * side, -0.02};
      for (const char* name : names) {
        all.push_back({std::string(name) + (side > 0 ? ".L" : ".R"), parent, offset});
        parent = static_cast<int>(all.size()) - 1;
        offset = std::string(name).ends_with("foot") ? Vec3{0.05, 0, -0.05} : Vec3{0.02, 0, -0.2};
      }
    }
  const int count = static_cast<int>(all.size());
  for (int i = 0; i < count; ++i) {
    const std::string bone = all[static_cast<std::size_t>(i)].name;
    all[static_cast<std::size_t>(i)].name = "ORG-" + bone;
    all.push_back({"DEF-" + bone, i, {}});
  }
  MeasuredMotion m = moving(all);
  for (std::size_t k = 0; k < m.rotations.size(); ++k) {
    const std::size_t i = k % all.size();
    m.rotations[k] = i < mechanism.size() || i >= static_cast<std::size_t>(count)
                         ? Quat{}
                         : axis_angle({0, 1, 0}, 0.2 * std::sin(0.3 * static_cast<double>(k / all.size()) + 0.9 * static_cast<double>(i)));
  }
  ASSERT_EQ(body::recognise_character(m).plan, body::BodyPlan::four_legs) << "by its mechanisms";
  std::vector<MeasuredMotion> motions = {m};
  std::vector<std::string> report;
  const body::Character c = arrange(motions, report);
  ASSERT_EQ(c.plan, body::BodyPlan::four_legs) << c.why_not;
  for (const SkeletonJoint& j : motions[0].skeleton.joints) EXPECT_TRUE(j.name.starts_with("DEF-")) << j.name;
  EXPECT_EQ(motions[0].skeleton.joints[static_cast<std::size_t>(c.arms[1].proximal)].name, "DEF-front_thigh.R");
}

TEST(DeformBones, OtherSkeletonsStayAsTheyAre) {
  std::vector<Bone> few = {{"root", -1, {}}};
  for (int i = 0; i < 7; ++i) few.push_back({"DEF-bone." + std::to_string(i), i, {0.1, 0, 0}});
  MeasuredMotion m = moving(few);
  EXPECT_FALSE(keep_deform_bones({&m, 1}));
  EXPECT_EQ(m.joint_count(), 8);
}

}  // namespace
}  // namespace ugoki::intake
