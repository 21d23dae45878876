#include "ugoki/motion_edit/layers.h"

#include <gtest/gtest.h>

#include <cmath>

#include "characters.h"

namespace ugoki::motion_edit {
namespace {

/// The motion with one link's joint displaced by `by` (rotation vector or angle, rad) in every frame after the first.
Motion raised(const Mechanism& m, const Motion& motion, int link, const Vec3& by) {
  Motion out = motion;
  for (int f = 1; f < out.frames; ++f) {
    const double step[6] = {by.x, by.y, by.z, 0, 0, 0};
    double* q = out.frame(f) + m.link(link).q_index;
    joint_integrate(m.link(link).joint, q, step, 1.0, q);
  }
  return out;
}

int arm_of(const Mechanism& m) {
  for (int i = 0; i < m.link_count(); ++i)
    if (m.link(i).label == "upper arm left") return i;
  return -1;
}

TEST(Layers, MixChangesOnlyTheJointsOfTheMask) {
  const Character character = human_walk();
  const int arm = arm_of(character.m());
  ASSERT_GT(arm, 0);
  const Motion other = raised(character.m(), character.motion, arm, {0.5, 0, 0});
  const std::vector<MaskEntry> entries = {{"upper arm left", 1, true}};
  const JointMask mask = make_mask(character.m(), entries).value();
  const Motion mixed = mix_joints(character.m(), character.motion, other, mask, {.fade = 0}).value();
  for (int f = 0; f < mixed.frames; ++f)
    for (int i = 0; i < character.m().link_count(); ++i)
      for (int k = 0; k < character.m().link(i).joint.nq(); ++k) {
        const int c = character.m().link(i).q_index + k;
        const Motion& source = mask[at(i)] == 1 ? other : character.motion;
        EXPECT_NEAR(mixed.frame(f)[c], source.frame(f)[c], 1e-12);
      }
  // Half the weight gives half the displacement.
  const Motion half = mix_joints(character.m(), character.motion, other, mask, {.weight = 0.5, .fade = 0}).value();
  double d[6];
  joint_difference(character.m().link(arm).joint, character.motion.frame(20) + character.m().link(arm).q_index,
                   half.frame(20) + character.m().link(arm).q_index, d);
  EXPECT_NEAR(norm(Vec3{d[0], d[1], d[2]}), 0.25, 1e-9);
}

TEST(Layers, AdditiveLayerAddsItsDisplacement) {
  const Character character = human_walk();
  const int arm = arm_of(character.m());
  Motion pose = character.motion;  // a constant pose: the first frame in all frames
  for (int f = 0; f < pose.frames; ++f) std::copy_n(character.motion.frame(0), pose.nq, pose.frame(f));
  const Motion layer = raised(character.m(), pose, arm, {0.4, 0, 0});
  const JointMask all = make_mask(character.m(), {}).value();
  EXPECT_LT(max_difference(character.m(), add_layer(character.m(), character.motion, pose, all, {.fade = 0}).value(), character.motion),
            1e-12);
  const Motion added = add_layer(character.m(), character.motion, layer, all, {.weight = 2, .fade = 0}).value();
  EXPECT_LT(max_difference(character.m(), added, raised(character.m(), character.motion, arm, {0.8, 0, 0})), 1e-9);
  // The layer with the opposite weight restores the base.
  const Motion back = add_layer(character.m(), added, layer, all, {.weight = -2, .fade = 0}).value();
  EXPECT_LT(max_difference(character.m(), back, character.motion), 1e-9);
}

TEST(Layers, FadeAvoidsJumpsAndOffsetDelays) {
  const Character character = human_walk();
  const int arm = arm_of(character.m());
  const Motion base = unrolled(character.m(), character.motion, 3);
  Motion other = raised(character.m(), character.motion, arm, {0.5, 0, 0});
  other.cyclic = false;
  const std::vector<MaskEntry> entries = {{"upper arm left", 1, false}};
  const JointMask mask = make_mask(character.m(), entries).value();
  const Motion mixed = mix_joints(character.m(), base, other, mask, {.offset = 0.5, .fade = 0.2}).value();
  double maximum = 0, d[6];
  const int q = character.m().link(arm).q_index;
  for (int f = 1; f < mixed.frames; ++f) {
    joint_difference(character.m().link(arm).joint, mixed.frame(f - 1) + q, mixed.frame(f) + q, d);
    maximum = std::max(maximum, norm(Vec3{d[0], d[1], d[2]}));
  }
  EXPECT_LT(maximum, 0.08);  // without a fade the arm would jump by 0.5 rad
  EXPECT_EQ(mixed.frame(5)[q], base.frame(5)[q]);
}

TEST(Layers, BadMasksAreRefused) {
  const Character character = human_walk();
  const std::vector<MaskEntry> unknown = {{"tentacle", 1, true}}, heavy = {{"*", 2, true}};
  const auto wrong = make_mask(character.m(), unknown);
  ASSERT_FALSE(wrong);
  EXPECT_NE(wrong.error().text().find("tentacle"), std::string::npos);
  EXPECT_FALSE(make_mask(character.m(), heavy));
  EXPECT_FALSE(mix_joints(character.m(), character.motion, character.motion, JointMask(3, 1.0)));
}

}  // namespace
}  // namespace ugoki::motion_edit
