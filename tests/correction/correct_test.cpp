// Physics correction: laws of mechanics in the corrected motion, checked by formulas that the correction does not use, and its interface.

#include "ugoki/correction/correct.h"

#include <gtest/gtest.h>

#include <cmath>

#include "../motion_edit/characters.h"
#include "keyed_jump.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/motion/band.h"
#include "ugoki/motion_edit/foot_contacts.h"
#include "ugoki/motion_edit/foot_lock.h"
#include "ugoki/samples/samples.h"

namespace ugoki::correction {
namespace {

using motion_edit::at;
using motion_edit::Character;

Character walk() {
  Character c = motion_edit::human_walk();
  c.motion = motion_edit::unrolled(c.m(), c.motion, 3);
  return c;
}

TEST(BandLeastSquares, GradientIsZeroAtTheSolution) {
  const std::size_t n = 40;
  BandLeastSquares band(n);
  struct Term {
    std::size_t first;
    std::array<double, 3> c;
    double value, weight;
  };
  std::vector<Term> terms;
  for (std::size_t i = 0; i < n; ++i) terms.push_back({i, {1, 0, 0}, std::cos(0.7 * static_cast<double>(i)), 0.1});
  for (std::size_t i = 0; i + 2 < n; ++i)
    terms.push_back({i, {1.5, -2, 0.25}, std::sin(static_cast<double>(i)), 1 + 0.1 * static_cast<double>(i)});
  for (const Term& t : terms) band.add(t.first, t.c, t.value, t.weight);
  const std::vector<double> x = band.solve();
  std::vector<double> gradient(n, 0.0);
  for (const Term& t : terms) {
    double error = -t.value;
    for (std::size_t k = 0; k < 3 && t.first + k < n; ++k) error += t.c[k] * x[t.first + k];
    for (std::size_t k = 0; k < 3 && t.first + k < n; ++k) gradient[t.first + k] += t.weight * error * t.c[k];
  }
  for (const double g : gradient) EXPECT_NEAR(g, 0, 1e-12);
}

TEST(Correction, MotionThatNeverTouchesTheFloorIsReturned) {
  Character c = walk();
  for (int f = 0; f < c.motion.frames; ++f) c.motion.frame(f)[2] += 2;
  CorrectOptions options;
  options.level_floor = false;
  const auto out = correct_motion(c.m(), c.motion, options);
  ASSERT_TRUE(out) << out.error().text();
  EXPECT_EQ(out->frames, c.motion.frames);
}

TEST(Correction, FlightsAreParabolasWithConstantMomentum) {
  if (!motion_edit::has_recordings()) GTEST_SKIP() << "the shared data were not found";
  const MeasuredMotion measured = motion_edit::read_recording("02", "02_04");
  const body::Body body = body::make_body(measured, {}).value();
  const Motion motion = body::to_motion(body, measured);
  const Mechanism& m = *body.mechanism;
  CorrectionReport report;
  const auto out = correct_motion(m, motion, {}, &report);
  ASSERT_TRUE(out) << out.error().text();
  EXPECT_EQ(report.flights, 1);
  // The flight, from the labels; the momentum from the velocities of the links, about the world's origin
  std::vector<Vec3> centre;
  std::vector<Vec6> momentum;
  std::vector<std::uint8_t> flies;
  std::vector<Pose> X(at(m.link_count()));
  std::vector<double> v(at(m.nv()));
  dynamics::Workspace ws(m);
  for (int f = 1; f + 1 < out->frames; ++f) {
    calc_poses(m, {out->frame(f), at(out->nq)}, X);
    centre.push_back(centre_of_mass(m, X));
    difference(m, {out->frame(f - 1), at(out->nq)}, {out->frame(f + 1), at(out->nq)}, v);
    for (double& x : v) x *= 0.5 * out->rate;
    dynamics::update_kinematics(m, {out->frame(f), at(out->nq)}, v, ws);
    momentum.push_back(dynamics::momentum(m, ws));
    flies.push_back(std::ranges::none_of(out->contacts, [&](const ContactTrack& t) { return t.on[at(f)] != 0; }));
  }
  const auto first = std::ranges::find(flies, 1) - flies.begin();
  auto last = first;
  while (flies[at(static_cast<int>(last) + 1)]) ++last;
  ASSERT_GT(last - first, 30) << "the jump lasts 0.3 s or more";
  const auto from = at(static_cast<int>(first)) + 2, to = at(static_cast<int>(last)) - 2;
  const double t = static_cast<double>(to - from) / out->rate;
  for (std::size_t i = from; i <= to; ++i) {  // the parabola through the first and the last point
    const double s = static_cast<double>(i - from) / out->rate;
    const Vec3 p = centre[from] + (centre[to] - centre[from]) * (s / t) + Vec3{0, 0, 0.5 * 9.81 * s * (t - s)};
    EXPECT_LT(norm(centre[i] - p), 0.003) << i;
  }
  const auto spin = [&](std::size_t i) { return momentum[i].w - cross(centre[i], momentum[i].v); };
  Vec3 mean;
  for (std::size_t i = from; i <= to; ++i) mean += spin(i) / static_cast<double>(to - from + 1);
  for (std::size_t i = from; i <= to; ++i) EXPECT_LT(norm(spin(i) - mean) / m.mass(), 0.01) << "m^2/s, at " << i;
}

// Jumps whose keys float, rush, or are low: the body falls freely afterwards, and legs that are already straight do not hold it back.
TEST(Correction, KeyedJumpsBecomePhysical) {
  const MeasuredMotion standing = samples::make_human_stand();
  const body::Body body = body::make_body(standing, {.keep_unmoved = true}).value();
  const Character c{body.mechanism, body::to_motion(body, standing)};
  for (const auto& [take_off, landing, apex] : {std::array{0.9, 1.7, 0.25}, std::array{0.9, 1.4, 0.3}, std::array{1.0, 1.35, 0.18}}) {
    const Motion keyed = keyed_jump(c, take_off, landing, apex);
    CorrectionReport report;
    ASSERT_TRUE(correct_motion(c.m(), keyed, {}, &report));
    EXPECT_EQ(report.flights, 1) << apex;
    EXPECT_GT(report.before.flight_g, 0.5) << apex;
    EXPECT_LT(report.after.flight_g, 0.02) << apex;
    EXPECT_LT(report.after.residual_bw, 0.3 * report.before.residual_bw) << apex;
    EXPECT_LT(report.after.jerk, 8) << apex;
    EXPECT_LT(report.after.penetration_mm, 1) << apex;
    EXPECT_LT(report.change_deg, 6) << apex;
  }
}

// A person who turns on the spot by 170 degrees on sliding soles, for example in a dance, still turns after the correction.
TEST(Correction, TurnsOnTheGroundAreKept) {
  const MeasuredMotion standing = samples::make_human_stand();
  const body::Body body = body::make_body(standing, {.keep_unmoved = true}).value();
  const Mechanism& m = *body.mechanism;
  Motion motion = body::to_motion(body, standing);
  const std::vector<double> q(motion.frame(0), motion.frame(0) + motion.nq);
  motion.frames = static_cast<int>(2.5 * motion.rate) + 1;
  motion.q.clear();
  motion.contacts.clear();
  for (int f = 0; f < motion.frames; ++f) {
    const double s = std::clamp((f / motion.rate - 0.75) / 1.0, 0.0, 1.0);
    std::vector<double> turned = q;
    displace_root(m, {0, 0, 0, 3.0 * s * s * (3 - 2 * s)}, turned);
    motion.q.insert(motion.q.end(), turned.begin(), turned.end());
  }
  CorrectionReport report;
  const auto out = correct_motion(m, motion, {}, &report);
  ASSERT_TRUE(out) << out.error().text();
  EXPECT_LT(report.change_deg, 1);
  EXPECT_LT(report.root_move_cm, 3);
}

// Feet of recordings slide by 2 to 3.5 cm in a stance. The legs remove this; the body keeps its way.
TEST(Correction, RecordedWalksKeepTheirWay) {
  if (!motion_edit::has_recordings()) GTEST_SKIP() << "the shared data were not found";
  for (const auto& [skeleton, name] : {std::pair{"16", "16_15"}, std::pair{"35", "35_01"}, std::pair{"07", "07_01"}}) {
    const MeasuredMotion measured = motion_edit::read_recording(skeleton, name);
    const body::Body body = body::make_body(measured, {}).value();
    CorrectionReport report;
    ASSERT_TRUE(correct_motion(*body.mechanism, body::to_motion(body, measured), {}, &report));
    EXPECT_LT(report.root_move_cm, 2) << name;
    EXPECT_LT(report.after.skate_cm, 0.3) << name;
    EXPECT_LT(report.after.residual_bw, 0.05) << name;
  }
}

TEST(Correction, CorrectedMotionIsChangedLittleBySecondCorrection) {
  const Character c = walk();
  const auto once = correct_motion(c.m(), c.motion);
  ASSERT_TRUE(once) << once.error().text();
  CorrectionReport report;
  ASSERT_TRUE(correct_motion(c.m(), *once, {}, &report));
  EXPECT_LT(report.change_deg, 1);
  EXPECT_LT(report.root_move_cm, 1);
}

TEST(Correction, StrengthInterpolates) {
  const Character c = walk();
  const auto none = correct_motion(c.m(), c.motion, {.strength = 0}), all = correct_motion(c.m(), c.motion),
             half = correct_motion(c.m(), c.motion, {.strength = 0.5});
  ASSERT_TRUE(none && all && half);
  EXPECT_EQ(none->q, c.motion.q);
  // The displacement of the floor is not scaled; the walk stands on z = 0 within 1 cm.
  for (int f = 0; f < c.motion.frames; f += 7)
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(half->frame(f)[k], 0.5 * (all->frame(f)[k] + c.motion.frame(f)[k]), 0.006);
}

TEST(Correction, CyclicMotionStaysCyclic) {
  const Character c = motion_edit::human_walk();
  const auto out = correct_motion(c.m(), c.motion);
  ASSERT_TRUE(out) << out.error().text();
  EXPECT_TRUE(out->cyclic);
  EXPECT_EQ(out->frames, c.motion.frames);
  std::vector<double> d(at(c.m().nv()));
  difference(c.m(), {out->frame(0), at(out->nq)}, {out->frame(out->frames - 1), at(out->nq)}, d);
  for (std::size_t i = 6; i < d.size(); ++i) EXPECT_NEAR(d[i], 0, 1e-9);
}

TEST(Correction, EqualInputGivesEqualBits) {
  const Character c = walk();
  EXPECT_EQ(correct_motion(c.m(), c.motion)->q, correct_motion(c.m(), c.motion)->q);
}

TEST(Correction, CanBeCancelledAndReportsProgress) {
  const Character c = walk();
  double last = -1;
  int calls = 0;
  CorrectOptions options;
  options.progress = [&](double done) {
    EXPECT_GE(done, last);
    last = done;
    return true;
  };
  ASSERT_TRUE(correct_motion(c.m(), c.motion, options));
  EXPECT_EQ(last, 1);
  options.progress = [&](double) { return ++calls < 4; };
  const auto stopped = correct_motion(c.m(), c.motion, options);
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().problems.front().code, ErrorCode::cancelled);
  EXPECT_EQ(calls, 4);
}

TEST(Correction, RefusesWhatItCannotCorrect) {
  const Character c = walk();
  EXPECT_FALSE(correct_motion(c.m(), c.motion, {.strength = std::nan("")}));
  EXPECT_FALSE(correct_motion(c.m(), c.motion, {.gravity = -1}));
  Motion two = c.motion;
  two.frames = 2;
  two.contacts.clear();
  two.q.resize(2 * at(two.nq));
  EXPECT_FALSE(correct_motion(c.m(), two));
  MechanismSpec spec;
  LinkSpec arm;
  arm.name = "arm";
  arm.joint.type = JointType::revolute;
  arm.inertia = Inertia::from_centre(1, {}, {1, 1, 1, 0, 0, 0});
  spec.links = {arm};
  const MechanismPtr fixed = Mechanism::make(spec).value();
  Motion swing;
  swing.nq = 1;
  swing.frames = 10;
  swing.q.assign(10, 0.0);
  const auto refused = correct_motion(*fixed, swing);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().text().find("not floating"), std::string::npos);
}

}  // namespace
}  // namespace ugoki::correction
