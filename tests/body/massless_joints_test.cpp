// Movable joints to which no body part gives mass: each gets a small mass, wherever it is in the tree.

#include <gtest/gtest.h>

#include "measured_files.h"
#include "ugoki/body/body.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::body {
namespace {

const std::vector<MeasuredDof> ball = {{{0, 0, 1}}, {{1, 0, 0}}, {{0, 1, 0}}};

/// Inserts a joint that turns and translates in every frame. @param index position in the skeleton; later joints move up by one
void insert_moving_joint(MeasuredMotion& m, int index, const std::string& name, int parent, const Vec3& offset) {
  Skeleton& s = m.skeleton;
  const std::size_t before = s.joints.size(), at = static_cast<std::size_t>(index);
  SkeletonJoint joint;
  joint.name = name;
  joint.parent = parent;
  joint.offset = offset;
  joint.dofs = ball;
  joint.translates = true;
  s.joints.insert(s.joints.begin() + index, joint);
  for (std::size_t i = at + 1; i < s.joints.size(); ++i)
    if (s.joints[i].parent >= index) ++s.joints[i].parent;
  std::vector<Vec3> translations;
  std::vector<Quat> rotations;
  for (int f = 0; f < m.frames; ++f) {
    const std::size_t first = static_cast<std::size_t>(f) * before;
    for (std::size_t i = 0; i <= before; ++i) {
      if (i == at) {
        translations.push_back(offset + Vec3{0, 0, 0.01 * f});
        rotations.push_back(exp_map({0.01 * f, 0.02 * f, 0}));
      }
      if (i == before) break;
      translations.push_back(m.translations[first + i]);
      rotations.push_back(m.rotations[first + i]);
    }
  }
  m.translations = std::move(translations);
  m.rotations = std::move(rotations);
}

/// Gives the character a root above the hips. @param moves the root moves; otherwise it stays at the origin
MeasuredMotion under_a_root(bool moves) {
  MeasuredMotion m = testing::made_character(20);
  insert_moving_joint(m, 0, "Reference", -1, {});
  m.skeleton.joints[1].parent = 0;
  const std::size_t n = m.skeleton.joints.size();
  for (std::size_t f = 0; f < 20 && !moves; ++f) {
    m.translations[f * n] = {};
    m.rotations[f * n] = {};
  }
  return m;
}

/// Checks that the subtree of every movable link has mass, and that the total mass equals the mass of the body.
void check_masses(const MeasuredMotion& measured) {
  const Result<Body> body = make_body(measured);
  ASSERT_TRUE(body) << body.error().text();
  EXPECT_TRUE(body->human) << body->report.front();
  const Mechanism& m = *body->mechanism;
  EXPECT_NEAR(m.mass(), 22.5 * body->height * body->height, 1e-9 * m.mass());
  for (const Link& l : m.links()) {
    EXPECT_GE(l.inertia.mass, 0) << l.name;
    if (l.joint.nv() > 0 && l.child < 0) EXPECT_GT(l.inertia.mass, 0.001) << l.name;
  }
  EXPECT_TRUE(check_motion(to_motion(*body, measured), m).empty());
}

TEST(MasslessJoints, SecondMovingRootGetsMass) {
  MeasuredMotion m = testing::made_character(20);
  insert_moving_joint(m, m.joint_count(), "Camera", -1, {1, 2, 0});
  check_masses(m);
}

TEST(MasslessJoints, MovingRootBeforeTheHipsGetsMass) {
  MeasuredMotion m = testing::made_character(20);
  insert_moving_joint(m, 0, "Camera", -1, {1, 2, 0});
  check_masses(m);
}

TEST(MasslessJoints, SeveralMovingRootsGetMass) {
  MeasuredMotion m = testing::made_character(20);
  for (const char* name : {"Camera", "", "Camera"}) insert_moving_joint(m, m.joint_count(), name, -1, {1, 2, 0});
  check_masses(m);
}

TEST(MasslessJoints, JointsWithoutANameGetLinksWithNames) {
  MeasuredMotion m = testing::made_character(20);
  for (int k = 0; k < 3; ++k) insert_moving_joint(m, m.joint_count(), "", 0, {0, 0, 0});
  const Result<Body> body = make_body(m);
  ASSERT_TRUE(body);
  for (const char* name : {"joint", "joint 2", "joint 3"}) EXPECT_GE(body->mechanism->find_link(name), 0) << name;
}

TEST(MasslessJoints, SiblingOfTheHipsGetsMass) {
  for (const bool moves : {false, true}) {
    MeasuredMotion m = under_a_root(moves);
    check_masses(m);
    insert_moving_joint(m, m.joint_count(), "Prop", 0, {0.3, 0, 0});  // after the hips in the order of joints
    check_masses(m);
    insert_moving_joint(m, 1, "Tracker", 0, {0.3, 0, 0});  // before the hips
    check_masses(m);
  }
}

TEST(MasslessJoints, ChainBesideTheHipsGetsMass) {
  MeasuredMotion m = under_a_root(true);
  insert_moving_joint(m, m.joint_count(), "Rod", 0, {0.3, 0, 0});
  insert_moving_joint(m, m.joint_count(), "Rod Tip", m.joint_count() - 1, {0, 0, 0.2});
  check_masses(m);
}

TEST(MasslessJoints, ChildOfTheHipsGetsMass) {
  MeasuredMotion m = testing::made_character(20);
  insert_moving_joint(m, m.joint_count(), "Holster", 0, {0, 0, 0});
  check_masses(m);
}

TEST(MasslessJoints, SixChannelsOnEveryJointAreAccepted) {
  MeasuredMotion m = under_a_root(true);
  insert_moving_joint(m, m.joint_count(), "Prop", 0, {0.3, 0, 0});
  const std::size_t n = m.skeleton.joints.size();
  for (SkeletonJoint& j : m.skeleton.joints) {
    j.dofs = ball;
    j.translates = true;
  }
  for (std::size_t k = 0; k < m.rotations.size(); ++k) {
    m.translations[k].z += 1e-4 * static_cast<double>(k / n);
    m.rotations[k] = normalized(m.rotations[k] * exp_map({0, 1e-3 * static_cast<double>(k / n), 0}));
  }
  check_masses(m);
}

}  // namespace
}  // namespace ugoki::body
