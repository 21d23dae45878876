#include "ugoki/motion_edit/layers.h"

#include <gtest/gtest.h>

#include <cmath>

#include "figures.h"

namespace ugoki::motion_edit {
namespace {

/// The walk with one link's joint moved by `by` (rotation vector or angle) at every frame after the first.
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

TEST(Layers, MixTakesOnlyTheJointsOfTheMask) {
  const Figure figure = human_walk();
  const int arm = arm_of(figure.m());
  ASSERT_GT(arm, 0);
  const Motion other = raised(figure.m(), figure.motion, arm, {0.5, 0, 0});
  const std::vector<MaskEntry> entries = {{"upper arm left", 1, true}};
  const JointMask mask = make_mask(figure.m(), entries).value();
  const Motion mixed = mix_joints(figure.m(), figure.motion, other, mask, {.fade = 0}).value();
  for (int f = 0; f < mixed.frames; ++f)
    for (int i = 0; i < figure.m().link_count(); ++i)
      for (int k = 0; k < figure.m().link(i).joint.nq(); ++k) {
        const int c = figure.m().link(i).q_index + k;
        const Motion& source = mask[at(i)] == 1 ? other : figure.motion;
        EXPECT_NEAR(mixed.frame(f)[c], source.frame(f)[c], 1e-12);
      }
  // Half the weight is half the way.
  const Motion half = mix_joints(figure.m(), figure.motion, other, mask, {.weight = 0.5, .fade = 0}).value();
  double d[6];
  joint_difference(figure.m().link(arm).joint, figure.motion.frame(20) + figure.m().link(arm).q_index,
                   half.frame(20) + figure.m().link(arm).q_index, d);
  EXPECT_NEAR(norm(Vec3{d[0], d[1], d[2]}), 0.25, 1e-9);
}

TEST(Layers, AdditiveLayerDoesItsDifferenceOnTop) {
  const Figure figure = human_walk();
  const int arm = arm_of(figure.m());
  Motion pose = figure.motion;  // a layer that holds its first frame, then raises the arm
  for (int f = 0; f < pose.frames; ++f) std::copy_n(figure.motion.frame(0), pose.nq, pose.frame(f));
  const Motion layer = raised(figure.m(), pose, arm, {0.4, 0, 0});
  const JointMask all = make_mask(figure.m(), {}).value();
  EXPECT_LT(greatest_difference(figure.m(), add_layer(figure.m(), figure.motion, pose, all, {.fade = 0}).value(), figure.motion), 1e-12);
  const Motion added = add_layer(figure.m(), figure.motion, layer, all, {.weight = 2, .fade = 0}).value();
  EXPECT_LT(greatest_difference(figure.m(), added, raised(figure.m(), figure.motion, arm, {0.8, 0, 0})), 1e-9);
  // And with the opposite weight it is taken away again.
  const Motion back = add_layer(figure.m(), added, layer, all, {.weight = -2, .fade = 0}).value();
  EXPECT_LT(greatest_difference(figure.m(), back, figure.motion), 1e-9);
}

TEST(Layers, FadeAndOffsetEaseIn) {
  const Figure figure = human_walk();
  const int arm = arm_of(figure.m());
  const Motion base = unrolled(figure.m(), figure.motion, 3);
  Motion other = raised(figure.m(), figure.motion, arm, {0.5, 0, 0});
  other.cyclic = false;
  const std::vector<MaskEntry> entries = {{"upper arm left", 1, false}};
  const JointMask mask = make_mask(figure.m(), entries).value();
  const Motion mixed = mix_joints(figure.m(), base, other, mask, {.offset = 0.5, .fade = 0.2}).value();
  double most = 0, d[6];
  const int q = figure.m().link(arm).q_index;
  for (int f = 1; f < mixed.frames; ++f) {
    joint_difference(figure.m().link(arm).joint, mixed.frame(f - 1) + q, mixed.frame(f) + q, d);
    most = std::max(most, norm(Vec3{d[0], d[1], d[2]}));
  }
  EXPECT_LT(most, 0.08);  // 0.5 rad at once would be a jump
  EXPECT_EQ(mixed.frame(5)[q], base.frame(5)[q]);
}

TEST(Layers, BadMasksAreRefused) {
  const Figure figure = human_walk();
  const std::vector<MaskEntry> unknown = {{"tentacle", 1, true}}, heavy = {{"*", 2, true}};
  const auto wrong = make_mask(figure.m(), unknown);
  ASSERT_FALSE(wrong);
  EXPECT_NE(wrong.error().text().find("tentacle"), std::string::npos);
  EXPECT_FALSE(make_mask(figure.m(), heavy));
  EXPECT_FALSE(mix_joints(figure.m(), figure.motion, figure.motion, JointMask(3, 1.0)));
}

}  // namespace
}  // namespace ugoki::motion_edit
