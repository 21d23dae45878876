// Floor under a measured motion; contact labels; sliding feet and ground penetration.

#include "ugoki/body/floor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "measured_files.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion/measures.h"
#include "ugoki/samples/samples.h"

namespace ugoki::body {
namespace {

TEST(Floor, HeightIsFoundAndTheMotionIsShiftedToZero) {
  const MeasuredMotion low = testing::made_character(240, 0.25), high = testing::made_character(240, -1.0);
  const auto a = make_body(low), b = make_body(high);
  ASSERT_TRUE(a && b);
  EXPECT_NEAR(calc_floor_pose(*a, low).p.z - calc_floor_pose(*b, high).p.z, -1.25, 1e-9);
  // The soles of the synthetic character are 0.03 m below the ball of the foot. The body model assumes 1.9 % of the height.
  EXPECT_NEAR(calc_floor_pose(*a, low).p.z, -0.25 - 0.02 - 0.03 + 0.019 * a->height, 0.021);
  EXPECT_EQ(calc_floor_pose(*a, low).R, Mat3::identity());
}

TEST(Floor, TiltIsFoundAndRemoved) {
  const double slope = 0.02;
  const MeasuredMotion measured = testing::made_character(600, 0.1, slope);  // five stance positions over two metres
  const auto body = make_body(measured);
  ASSERT_TRUE(body.has_value());
  const FloorFit fit = fit_floor(measured, body->soles, body->height);
  EXPECT_TRUE(fit.found);
  EXPECT_NEAR(fit.tilt, atan(slope), 1e-4);
  EXPECT_NEAR(norm(fit.R_level * normalized(Vec3{-slope, 0, 1}) - Vec3{0, 0, 1}), 0, 1e-4);
  BodyOptions unlevelled;
  unlevelled.level_floor = false;
  EXPECT_EQ(calc_floor_pose(*make_body(measured, unlevelled), measured).p, Vec3{});
}

TEST(Floor, LevelFloorStaysLevel) {
  const MeasuredMotion measured = testing::made_character(600, 0.1, 0);
  const auto body = make_body(measured);
  EXPECT_EQ(fit_floor(measured, body->soles, body->height).tilt, 0);
}

// In place, feet are slow only where they turn back, which is in the air at the front.
TEST(Floor, WalkInPlaceHasTheFloorOfTheWalk) {
  const MeasuredMotion walk = samples::make_human_walk();
  const Body body = make_body(walk, {.keep_unmoved = true}).value();
  const std::size_t n = walk.skeleton.joints.size(), last = static_cast<std::size_t>(walk.frames - 1);
  MeasuredMotion spot = walk;
  const Vec3 way = walk.translations[last * n] - walk.translations[0];
  for (std::size_t f = 0; f <= last; ++f)
    spot.translations[f * n] -= Vec3{way.x, way.y, 0} * (static_cast<double>(f) / static_cast<double>(last));
  EXPECT_NEAR(calc_floor_pose(body, spot).p.z, calc_floor_pose(body, walk).p.z, 0.003);
}

// As on a treadmill: low feet slide at 1.5 m/s, and feet 0.2 m above the floor rest for a moment.
TEST(Floor, WalkingOnTheSpotUsesTheLowestFrames) {
  MeasuredMotion spot = testing::made_character(240, 0.25);
  std::ranges::fill(spot.rotations, Quat{});
  const std::size_t n = spot.skeleton.joints.size();
  double lowest = 0;
  for (int f = 0; f < spot.frames; ++f) {
    const double t = f / spot.rate, phase = t - std::floor(t);
    Vec3& root = spot.translations[static_cast<std::size_t>(f) * n];
    if (f == 0) lowest = root.z;
    root = {phase < 0.4 ? 1.5 * phase : phase < 0.8 ? 0.6 : 0.6 - 3 * (phase - 0.8), 0, lowest + (phase < 0.4 ? 0.0 : 0.2)};
  }
  const MeasuredMotion standing = testing::made_character(240, 0.25);
  const auto body = make_body(spot);
  ASSERT_TRUE(body);
  EXPECT_NEAR(calc_floor_pose(*body, spot).p.z, calc_floor_pose(*make_body(standing), standing).p.z, 1e-3);
}

// Toes of cartoon characters with large feet sink into the floor for a short time while the heel leaves it.
TEST(Floor, SunkenToesDoNotLowerTheFloor) {
  MeasuredMotion motion = testing::made_character(240, 0.25);
  const auto before = make_body(motion);
  ASSERT_TRUE(before);
  const std::size_t n = motion.skeleton.joints.size();
  for (int f = 0; f < motion.frames; ++f) {
    if (f % 40 < 34) continue;
    for (const Sole& sole : before->soles) {
      Quat& turn = motion.rotations[static_cast<std::size_t>(f) * n + static_cast<std::size_t>(sole.foot)];
      turn = turn * axis_angle({0, 1, 0}, 1.3);
    }
  }
  const auto body = make_body(motion);
  ASSERT_TRUE(body);
  EXPECT_NEAR(calc_floor_pose(*body, motion).p.z, calc_floor_pose(*before, motion).p.z, 0.01);
}

/// A single ball-shaped foot that comes down, stands, leaves, and touches the ground briefly.
struct Hopper {
  MechanismPtr mechanism;
  Motion motion;
};
Hopper hopper() {
  MechanismSpec spec;
  spec.name = "hopper";
  LinkSpec link;
  link.name = "foot";
  link.label = "foot left";
  link.joint.type = JointType::floating;
  link.shapes = {Shape::sphere(0.1)};
  link.inertia = solid_inertia(link.shapes[0], 1000);
  spec.links = {link};
  Hopper out;
  out.mechanism = *Mechanism::make(spec);
  out.motion.rate = 100;
  out.motion.nq = 7;
  const auto add = [&](double x, double z) {
    const double q[7] = {x, 0, z, 1, 0, 0, 0};
    out.motion.q.insert(out.motion.q.end(), q, q + 7);
    ++out.motion.frames;
  };
  for (int i = 0; i < 30; ++i) add(0, 0.5 - 0.4 * i / 29.0);           // the foot comes down
  for (int i = 0; i < 40; ++i) add(0.001 * i, 0.1);                    // the foot stands, sliding at 0.1 m/s
  for (int i = 0; i < 20; ++i) add(0.039 + 0.02 * i, 0.1 + 0.01 * i);  // the foot leaves at 2 m/s
  for (int i = 0; i < 3; ++i) add(0.5, 0.11);                          // the foot touches the ground for 30 ms only
  for (int i = 0; i < 20; ++i) add(0.6 + 0.02 * i, 0.3);
  return out;
}

TEST(ContactLabels, OnlyStandingIsLabelled) {
  Hopper h = hopper();
  label_contacts(*h.mechanism, h.motion);
  ASSERT_EQ(h.motion.contacts.size(), 1u);
  EXPECT_EQ(h.motion.contacts[0].link, "foot");
  const auto& on = h.motion.contacts[0].on;
  int starts = 0, count = 0;
  for (std::size_t i = 0; i < on.size(); ++i) {
    starts += on[i] && (i == 0 || !on[i - 1]) ? 1 : 0;
    count += on[i];
  }
  EXPECT_EQ(starts, 1);
  EXPECT_NEAR(count, 40, 3);
  EXPECT_TRUE(on[45]);
  EXPECT_FALSE(on[15]);
  EXPECT_TRUE(check_motion(h.motion, *h.mechanism).empty());
}

TEST(ContactLabels, ShortGapIsClosed) {
  Hopper h = hopper();
  h.motion.frame(50)[2] = 0.2;  // a glitch of one frame
  label_contacts(*h.mechanism, h.motion);
  EXPECT_TRUE(h.motion.contacts[0].on[50]);
}

TEST(Measures, SkateIsThePathLengthOfTheStandingFoot) {
  const Hopper h = hopper();
  FootSkate skate(*h.mechanism, find_feet(*h.mechanism));
  std::vector<Pose> X(1);
  for (int f = 0; f < h.motion.frames; ++f) {
    calc_poses(*h.mechanism, std::span(h.motion.frame(f), 7), X);
    const std::uint8_t on = f >= 30 && f < 70 ? 1 : 0;
    skate.add(X, std::span(&on, 1), 0.01);
  }
  EXPECT_EQ(skate.stances(), 1);
  EXPECT_NEAR(skate.mean_per_stance_cm(), 3.9, 1e-9);
  EXPECT_NEAR(skate.worst_stance_cm(), 3.9, 1e-9);
  EXPECT_NEAR(skate.rms_speed(), 0.1, 1e-9);
  skate.reset();
  EXPECT_EQ(skate.stances(), 0);
}

TEST(Measures, ARollingFootDoesNotSkate) {
  const Hopper h = hopper();
  FootSkate skate(*h.mechanism, find_feet(*h.mechanism));
  const std::uint8_t on = 1;
  for (int f = 0; f < 100; ++f) {
    const double turn = 0.001 * f;  // the ball rolls without slipping: x = r * turn
    const Pose X{rotation_about({0, 1, 0}, turn), {0.1 * turn, 0, 0.1}};
    skate.add(std::span(&X, 1), std::span(&on, 1), 0.01);
  }
  EXPECT_LT(skate.mean_per_stance_cm(), 1e-3);
}

TEST(Measures, PenetrationIsTheDepthBelowTheGround) {
  const Hopper h = hopper();
  GroundPenetration penetration(*h.mechanism, 0.02);
  for (const double z : {0.5, 0.11, 0.12}) {  // m: the ball's centre in three frames: above the ground, 10 mm deep, touching the ground
    const Pose X{Mat3::identity(), {0, 0, z}};
    penetration.add(std::span(&X, 1));
  }
  EXPECT_NEAR(penetration.worst_mm(), 10, 1e-9);
  EXPECT_NEAR(penetration.rms_mm(), 10 / std::sqrt(3.0), 1e-9);
  EXPECT_EQ(penetration.worst_link(), 0);
}

TEST(ContactLabels, SharedWalkAlternatesItsFeet) {
  if (testing::human_files().empty()) GTEST_SKIP() << "The shared measured data are absent.";
  const MeasuredMotion measured = testing::read("asf_amc/35_01.amc");
  const auto body = make_body(measured);
  const Motion motion = to_motion(*body, measured);
  ASSERT_EQ(motion.contacts.size(), 2u);
  int none = 0, one = 0, both = 0;
  for (std::size_t f = 0; f < static_cast<std::size_t>(motion.frames); ++f) {
    const bool l = motion.contacts[0].on[f] != 0, r = motion.contacts[1].on[f] != 0;
    none += !l && !r ? 1 : 0;
    one += l != r ? 1 : 0;
    both += l && r ? 1 : 0;
  }
  EXPECT_EQ(none, 0);
  EXPECT_GT(both, 0.12 * motion.frames);  // double support is 20 to 33 % of a walk; the bound of 12 % leaves a margin
  EXPECT_LT(both, 0.40 * motion.frames);
  EXPECT_GT(one, 0.6 * motion.frames);
}

TEST(ContactLabels, SharedRunHasFlightPhases) {
  if (testing::human_files().empty()) GTEST_SKIP() << "The shared measured data are absent.";
  const MeasuredMotion measured = testing::read("asf_amc/02_03.amc");
  const auto body = make_body(measured);
  const Motion motion = to_motion(*body, measured);
  int none = 0, both = 0;
  for (std::size_t f = 0; f < static_cast<std::size_t>(motion.frames); ++f) {
    const bool l = motion.contacts[0].on[f] != 0, r = motion.contacts[1].on[f] != 0;
    none += !l && !r ? 1 : 0;
    both += l && r ? 1 : 0;
  }
  EXPECT_GT(none, 0.25 * motion.frames);
  EXPECT_EQ(both, 0);
}

}  // namespace
}  // namespace ugoki::body
