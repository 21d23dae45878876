#include "ugoki/motion_edit/curves.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "characters.h"

namespace ugoki::motion_edit {
namespace {

/// Maximum rotation [degrees] and translation [m] of any joint between the two motions, from joint poses: independent of how curves
/// represent rotations.
std::pair<double, double> max_error(const Mechanism& m, const Motion& a, const Motion& b) {
  double turn = 0, slide = 0;
  for (int f = 0; f < a.frames; ++f)
    for (const Link& link : m.links()) {
      const Pose d = joint_pose(link.joint, a.frame(f) + link.q_index).inverse() * joint_pose(link.joint, b.frame(f) + link.q_index);
      if (link.joint.type == JointType::universal) {
        for (int k = 0; k < 2; ++k) turn = std::max(turn, std::fabs(a.frame(f)[link.q_index + k] - b.frame(f)[link.q_index + k]));
        continue;
      }
      turn = std::max(turn, norm(log_map(to_quat(d.R))));
      slide = std::max(slide, norm(d.p));
    }
  return {turn * 180 / pi, slide};
}

TEST(Curves, ReducedMotionIsWithinTheBounds) {
  for (const Character& character : {human_walk(), dog_trot()}) {
    const Motion motion = unrolled(character.m(), character.motion, 2);
    int before = 1 << 30;
    for (const double degrees : {0.05, 0.5, 3.0}) {
      const ReduceOptions bound{degrees, 0.01 * degrees};
      const MotionCurves curves = reduce_keys(character.m(), motion, bound).value();
      const auto [turn, slide] = max_error(character.m(), to_motion(character.m(), curves).value(), motion);
      EXPECT_LE(turn, degrees * (1 + 1e-9)) << character.m().name();
      EXPECT_LE(slide, bound.metres * (1 + 1e-9));
      EXPECT_LT(curves.key_count(), before);
      before = curves.key_count();
    }
    EXPECT_LT(before, motion.frames * static_cast<int>(character.m().links().size()) / 8);
  }
}

TEST(Curves, SeveralFullTurnsAreWithinTheBounds) {
  const MechanismPtr ball = samples::make_ball();
  Motion motion;
  motion.mechanism = ball->name();
  motion.rate = 100;
  motion.frames = 301;
  motion.nq = ball->nq();
  for (int f = 0; f < motion.frames; ++f) {  // the joint makes about five turns about a slowly rotating axis
    const double t = f / 100.0;
    const Quat q = exp_map(Vec3{std::cos(0.4 * t), std::sin(0.4 * t), 0.3} * 3.0) * axis_angle({0, 0, 1}, 10 * t);
    for (const double x : {t, 0.0, 1 + t - t * t, q.w, q.x, q.y, q.z}) motion.q.push_back(x);
  }
  const MotionCurves curves = reduce_keys(*ball, motion, {0.5, 0.001}).value();
  const auto [turn, slide] = max_error(*ball, to_motion(*ball, curves).value(), motion);
  EXPECT_LE(turn, 0.5);
  EXPECT_LE(slide, 0.001);
  EXPECT_LT(curves.curves[0].keys.size(), 6U);  // a parabola needs few keys
}

TEST(Curves, KeysAreAddedMovedAndDeleted) {
  const Character character = human_walk();
  MotionCurves curves = reduce_keys(character.m(), character.motion, {1, 0.005}).value();
  Curve& curve = curves.curves[at(curves.find(character.m().link(0).name, Curve::Kind::location))];
  const Curve before = curve;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(0, character.motion.duration());
  int added = 0;
  for (int i = 0; i < 20; ++i) added += add_key(curve, any(random)) ? 1 : 0;
  EXPECT_EQ(curve.keys.size(), before.keys.size() + at(added));
  for (double t = 0; t < character.motion.duration(); t += 0.003)
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_NEAR(curve.value(t)[k], before.value(t)[k], 1e-12) << "a new key does not change the shape; seed 3";
  const int key = add_key(curve, 0.5 * (curve.keys[1].time + curve.keys[2].time)).value();
  auto value = curve.keys[at(key)].value;
  value[2] += 0.1;
  EXPECT_TRUE(move_key(curve, key, curve.keys[at(key)].time, value));
  EXPECT_EQ(curve.value(curve.keys[at(key)].time)[2], value[2]);
  EXPECT_FALSE(move_key(curve, key, 99, value));
  EXPECT_TRUE(set_slopes(curve, key, {0, 0, 1}, {0, 0, -1}));
  const double t = curve.keys[at(key)].time;
  EXPECT_NEAR((curve.value(t)[2] - curve.value(t - 1e-6)[2]) / 1e-6, 1, 5e-3);
  EXPECT_NEAR((curve.value(t + 1e-6)[2] - curve.value(t)[2]) / 1e-6, -1, 5e-3);
  EXPECT_TRUE(delete_key(curve, key));
  EXPECT_FALSE(delete_key(curve, 1000));
  while (curve.keys.size() > 1) EXPECT_TRUE(delete_key(curve, 0));
  const auto last = delete_key(curve, 0);
  ASSERT_FALSE(last);
  EXPECT_NE(last.error().text().find("last key"), std::string::npos);
  const auto twice = add_key(curve, curve.keys[0].time);
  EXPECT_FALSE(twice);
}

TEST(Curves, CurvesOfAnotherMechanismAreRefused) {
  const Character human = human_walk(), dog = dog_trot();
  const MotionCurves curves = reduce_keys(human.m(), human.motion).value();
  const auto wrong = to_motion(dog.m(), curves);
  ASSERT_FALSE(wrong);
  EXPECT_NE(wrong.error().text().find("no such link"), std::string::npos);
  EXPECT_FALSE(reduce_keys(human.m(), human.motion, {0, 1}));
}

}  // namespace
}  // namespace ugoki::motion_edit
