#include "ugoki/motion_edit/edit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "characters.h"
#include "ugoki/motion_edit/foot_contacts.h"
#include "ugoki/motion_edit/foot_lock.h"
#include "ugoki/motion_edit/layers.h"
#include "ugoki/motion_edit/root_path.h"
#include "ugoki/motion_edit/to_measured.h"

namespace ugoki::motion_edit {
namespace {

Motion labelled(const Character& character) {
  Motion motion = character.motion;
  set_labels(character.m(), find_contacts(character.m(), motion), motion);
  return motion;
}

TEST(Edit, TrimAndReverse) {
  const Character character = human_walk();
  const Motion walk = labelled(character);
  const Motion part = trim(walk, 5, 20).value();
  EXPECT_EQ(part.frames, 16);
  EXPECT_FALSE(part.cyclic);
  for (int k = 0; k < walk.nq; ++k) EXPECT_EQ(part.frame(3)[k], walk.frame(8)[k]);
  EXPECT_EQ(part.contacts[0].on[3], walk.contacts[0].on[8]);
  EXPECT_EQ(trim(walk, 0, walk.frames - 1).value().q, walk.q);
  EXPECT_EQ(reverse(reverse(walk)).q, walk.q);
  for (int k = 0; k < walk.nq; ++k) EXPECT_EQ(reverse(walk).frame(0)[k], walk.frame(walk.frames - 1)[k]);
  for (const auto& [first, last] : {std::pair{-1, 5}, {0, walk.frames}, {7, 6}}) {
    const auto wrong = trim(walk, first, last);
    ASSERT_FALSE(wrong);
    EXPECT_NE(wrong.error().text().find(std::to_string(last)), std::string::npos);
  }
}

TEST(Edit, ResampleKeepsTheMotion) {
  const Character character = human_walk();
  const Motion walk = unrolled(character.m(), character.motion, 2);
  EXPECT_LT(max_difference(character.m(), resample(character.m(), walk, walk.rate).value(), walk), 1e-12);
  const Motion there = resample(character.m(), walk, 4 * walk.rate).value();
  EXPECT_EQ(there.frames, 4 * (walk.frames - 1) + 1);
  const Motion back =
      resample(character.m(), there, walk.rate).value();  // cut-off frequency 0.4 times the rate, far above the frequencies of a walk
  EXPECT_LT(max_difference(character.m(), back, walk), 0.03);
  const Motion around = resample(character.m(), character.motion, 77).value();
  EXPECT_NEAR(around.duration(), character.motion.duration(), 1e-12);
  EXPECT_TRUE(around.cyclic);
  for (const double rate : {0.0, -5.0, 1e9, static_cast<double>(NAN)}) EXPECT_FALSE(resample(character.m(), walk, rate)) << rate;
}

TEST(Edit, ScaleKeepsDynamicsByFroude) {
  const Character character = human_walk();
  const Motion small = scale(character.m(), character.motion, {.length = 0.25, .froude = true}).value();
  EXPECT_NEAR(small.duration(), 0.5 * character.motion.duration(), 1e-12);
  EXPECT_NEAR(small.frame(9)[0], 0.25 * character.motion.frame(9)[0], 1e-15);
  for (int k = 3; k < small.nq; ++k) EXPECT_EQ(small.frame(9)[k], character.motion.frame(9)[k]);
  EXPECT_FALSE(scale(character.m(), character.motion, {.length = 0}));
  EXPECT_FALSE(scale(character.m(), character.motion, {.time = -1}));
}

TEST(Edit, TimeWarpKeepsPosesAndContacts) {
  const Character character = human_walk();
  const Motion walk = labelled(character);
  const double T = walk.duration();
  const TimePoint same[] = {{0, 0}, {T, T}};
  EXPECT_LT(max_difference(character.m(), time_warp(character.m(), walk, same).value(), walk), 1e-12);
  const TimePoint slow[] = {{0, 0}, {T, 0.5 * T}, {1.5 * T, T}};
  const Motion warped = time_warp(character.m(), walk, slow).value();
  EXPECT_NEAR(warped.duration(), 1.5 * T, 1 / walk.rate);
  std::vector<double> q(at(walk.nq)), d(at(character.m().nv()));
  sample(warped, character.m(), T, q);
  std::vector<double> wanted(q.size());
  sample(walk, character.m(), 0.5 * T, wanted);
  difference(character.m(), q, wanted, d);
  for (const double x : d) EXPECT_LT(std::fabs(x), 0.02);
  const auto share = [](const Motion& m) {
    double sum = 0;
    for (const std::uint8_t on : m.contacts[0].on) sum += on;
    return sum / m.frames;
  };
  EXPECT_GT(share(warped), 0.2);
  EXPECT_EQ(warped.contacts[0].on.size(), at(warped.frames));
  const TimePoint back[] = {{0, 0}, {1, 0.5}, {2, 0.2}}, outside[] = {{0, 0}, {1, 99}};
  EXPECT_FALSE(time_warp(character.m(), walk, back));
  const auto wrong = time_warp(character.m(), walk, outside);
  ASSERT_FALSE(wrong);
  EXPECT_NE(wrong.error().text().find("99"), std::string::npos);
}

TEST(Edit, JoinAlignsTheSecondMotionWithTheEndOfTheFirst) {
  const Character character = human_walk();
  const Motion walk = labelled(character);
  Motion turned = walk;
  for (int f = 0; f < turned.frames; ++f) displace_root(character.m(), {3, -7, 0, 2.1}, {turned.frame(f), at(turned.nq)});
  const Motion both = join(character.m(), walk, turned, {.blend = 0}).value();
  EXPECT_LT(max_difference(character.m(), both, unrolled(character.m(), walk, 2)), 1e-9);
  const Motion soft = join(character.m(), walk, turned, {.blend = 0.2}).value();
  EXPECT_NEAR(soft.duration(), 2 * walk.duration() - 0.2, 1.01 / walk.rate);
  double maximum = 0, usual = 0;
  std::vector<double> v(at(character.m().nv()));
  for (int f = 1; f < soft.frames; ++f) {
    difference(character.m(), {soft.frame(f - 1), at(soft.nq)}, {soft.frame(f), at(soft.nq)}, v);
    for (const double x : v) maximum = std::max(maximum, std::fabs(x));
  }
  for (int f = 1; f < walk.frames; ++f) {
    difference(character.m(), {walk.frame(f - 1), at(walk.nq)}, {walk.frame(f), at(walk.nq)}, v);
    for (const double x : v) usual = std::max(usual, std::fabs(x));
  }
  EXPECT_LT(maximum, 2.5 * usual);
  EXPECT_FALSE(join(character.m(), walk, turned, {.blend = 50}));
  const Character dog = dog_trot();
  EXPECT_FALSE(join(character.m(), walk, dog.motion));
}

TEST(Edit, OptionsOutOfRangeAreRefused) {
  const Character character = human_walk();
  const Mechanism& m = character.m();
  const Motion& walk = character.motion;
  const double nan = NAN, inf = INFINITY;
  for (const double end : {1e9, 1e300, inf})
    EXPECT_FALSE(time_warp(m, walk, std::vector<TimePoint>{{0, 0}, {end, walk.duration()}})) << end;
  EXPECT_FALSE(time_warp(m, walk, std::vector<TimePoint>{{-1e300, 0}, {1e300, walk.duration()}}));
  const auto too_long = time_warp(m, walk, std::vector<TimePoint>{{0, 0}, {1e9, walk.duration()}});
  EXPECT_NE(too_long.error().text().find("frames"), std::string::npos) << too_long.error().text();
  Motion long_walk = walk;
  long_walk.cyclic = false;
  long_walk.rate = 0.01;
  EXPECT_FALSE(resample(m, long_walk, 100000));
  for (const ScaleOptions& o :
       {ScaleOptions{.length = 1e300}, ScaleOptions{.time = 1e7}, ScaleOptions{.time = 1e-6}, ScaleOptions{.length = nan}})
    EXPECT_FALSE(scale(m, walk, o));
  EXPECT_FALSE(join(m, walk, walk, {.blend = nan}));
  for (const double x : {1e300, nan, inf}) EXPECT_FALSE(bend_path(m, walk, std::vector<PathPoint>{{0, 0}, {x, 1}})) << x;
  FootContacts contacts = find_contacts(m, walk);
  for (const FootLockOptions& o :
       {FootLockOptions{.ease = nan}, FootLockOptions{.ease = 1e300}, FootLockOptions{.stretch = 0}, FootLockOptions{.drop_time = -1}})
    EXPECT_FALSE(lock_feet(m, walk, contacts, o));
  contacts.ground = nan;
  EXPECT_FALSE(lock_feet(m, walk, contacts));
  const JointMask all = make_mask(m, {}).value();
  EXPECT_FALSE(mix_joints(m, walk, walk, all, {.offset = nan}));
  EXPECT_FALSE(add_layer(m, walk, walk, all, {.fade = inf}));
}

TEST(RootPath, BentWalkFollowsTheCurveWithoutSliding) {
  const Character character = human_walk();
  const Motion walk = unrolled(character.m(), character.motion, 5);
  std::vector<PathPoint> cycle;
  for (int i = 0; i <= 12; ++i) cycle.push_back({3 * std::sin(0.2 * i), 3 * (1 - std::cos(0.2 * i))});
  FootLockReport report;
  const Motion bent = bend_path(character.m(), walk, cycle, {}, &report).value();
  const std::vector<PathPoint> way = root_path(character.m(), bent);
  for (std::size_t f = 0; f < way.size(); ++f) {
    const double r = std::hypot(way[f].x, way[f].y - 3);
    EXPECT_NEAR(r, 3, 0.06) << f;
  }
  const double straight = std::hypot(walk.frame(walk.frames - 1)[0] - walk.frame(0)[0], walk.frame(walk.frames - 1)[1] - walk.frame(0)[1]);
  const double turn = root_placement(character.m(), {bent.frame(bent.frames - 1), at(bent.nq)}).heading -
                      root_placement(character.m(), {bent.frame(0), at(bent.nq)}).heading;
  EXPECT_NEAR(turn, straight / 3, 0.15);
  EXPECT_LT(report.after.worst_cm, 1.0);
  // Bending along its own path returns the original motion.
  std::vector<PathPoint> own;
  const std::vector<PathPoint> before = root_path(character.m(), walk);
  for (std::size_t f = 0; f < before.size(); f += 20) own.push_back(before[f]);
  own.push_back(before.back());
  RootPathOptions only;
  only.lock_feet = false;
  EXPECT_LT(max_difference(character.m(), bend_path(character.m(), walk, own, only).value(), walk), 0.03);
  const PathPoint one[] = {{1, 1}, {1, 1}};
  EXPECT_FALSE(bend_path(character.m(), walk, one));
}

TEST(ToMeasured, JointsHaveThePositionsOfTheLinks) {
  for (const Character& character : {human_walk(), dog_trot()}) {
    const MeasuredMotion measured = to_measured(character.m(), character.motion);
    std::vector<Pose> X(at(character.m().link_count())), Y;
    for (int f = 0; f < character.motion.frames; f += 5) {
      calc_poses(character.m(), {character.motion.frame(f), at(character.motion.nq)}, X);
      measured.calc_joint_poses(f, Y);
      for (std::size_t i = 0; i < X.size(); ++i) EXPECT_LT(norm(X[i].p - Y[i].p), 1e-9) << character.m().links()[i].name;
    }
    // A body made from the measured motion reproduces it.
    const auto body = body::make_body(measured, {.level_floor = false});
    ASSERT_TRUE(body);
    EXPECT_LT(body::calc_position_error(*body, measured, body::to_motion(*body, measured)), 1e-5);
  }
}

}  // namespace
}  // namespace ugoki::motion_edit
