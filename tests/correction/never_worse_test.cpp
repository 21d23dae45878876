// A correction never makes a motion worse: measures of `ugoki judge` that were within their limits stay there, and the centre of mass moves
// no farther than the fault requires. For clean motions, planted faults, and keys of an animator, looped and not.

#include <gtest/gtest.h>

#include <cmath>
#include <ctime>

#include "../motion_edit/characters.h"
#include "faults.h"
#include "keyed_jump.h"
#include "keyed_pose.h"
#include "keyed_roll.h"
#include "ugoki/correction/correct.h"
#include "ugoki/naturalness/judge_motion.h"
#include "ugoki/samples/samples.h"

namespace ugoki::correction {
namespace {

using motion_edit::at;
using motion_edit::Character;

std::vector<Vec3> centres(const Mechanism& m, const Motion& motion) {
  std::vector<Vec3> out;
  std::vector<Pose> X(at(m.link_count()));
  for (int f = 0; f < motion.frames; ++f) {
    calc_poses(m, {motion.frame(f), at(motion.nq)}, X);
    out.push_back(centre_of_mass(m, X));
  }
  return out;
}

/// m: path length of the slide of the lowest point of the body, which should rest; maximum distance of this point from z = 0.
struct Slide {
  double way = 0, height = 0;
};
Slide slide_of(const Mechanism& m, const Motion& motion) {
  Slide out;
  std::vector<Pose> X(at(m.link_count())), before(X.size());
  double around = 0;
  for (int f = 0; f < motion.frames; ++f) {
    calc_poses(m, {motion.frame(f), at(motion.nq)}, X);
    double low = 1e9;
    Vec3 step;
    for (std::size_t i = 0; i < X.size(); ++i)
      for (const SupportPoint& p : support_points(m.links()[i])) {
        const double z = (X[i] * p.p).z - p.radius;
        if (z >= low) continue;
        low = z;
        const Vec3 point = p.p + transpose_times(X[i].R, Vec3{0, 0, -p.radius});
        step = X[i] * point - before[i] * point;
      }
    if (f > 0) out.way += std::hypot(step.x, step.y);
    around = std::max(around, std::fabs(low));
    before = X;
  }
  out.height = around;
  return out;
}

/// s: longest time without contact of a foot.
double longest_flight(const Motion& motion) {
  int longest = 0, now = 0;
  for (int f = 0; f < motion.frames; ++f) {
    now = std::ranges::any_of(motion.contacts, [&](const ContactTrack& t) { return t.on[at(f)] != 0; }) ? 0 : now + 1;
    longest = std::max(longest, now);
  }
  return longest / motion.rate;
}

/// Bound of the movement of the centre of mass. The root moves over the ground by at most the slide of the feet, and 15 cm for balance;
/// vertically by the height of the feet over the floor, 10 cm for the load, and by the height g T^2 / 8 of a flight of T.
void expect_small_move(const Character& c, const Motion& given, const Motion& made) {
  const std::vector<Vec3> a = centres(c.m(), given), b = centres(c.m(), made);
  const Slide slide = slide_of(c.m(), given);
  const double flight = longest_flight(made);
  double level = 0, up = 0;
  for (std::size_t f = 0; f < b.size(); ++f) {
    const Vec3 d = b[f] - a[f * (a.size() - 1) / (b.size() - 1)];  // at equal phase, because flights with wrong gravity are retimed
    level = std::max(level, std::hypot(d.x, d.y));
    up = std::max(up, std::fabs(d.z));
  }
  EXPECT_LE(level, slide.way + 0.15);
  EXPECT_LE(up, slide.height + 0.1 + 9.81 * flight * flight / 8);
}

CorrectionReport expect_no_worse(const std::string& name, const Character& c, const Motion& motion) {
  SCOPED_TRACE(name);
  CorrectionReport report;
  const std::clock_t start = std::clock();
  const auto made = correct_motion(c.m(), motion, {}, &report);
  const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  EXPECT_TRUE(made) << made.error().text();
  if (!made) return report;
  EXPECT_LT(seconds, 2 * std::max(1.0, motion.duration())) << "processor time";
  const naturalness::Report before = naturalness::judge_motion(c.m(), motion), after = naturalness::judge_motion(c.m(), *made);
  for (const naturalness::MeasureInfo& info : naturalness::measure_list()) {
    const auto &x = before.measures[index_of(info.id)], &y = after.measures[index_of(info.id)];
    if (x.grade() != naturalness::Grade::none && x.grade() != naturalness::Grade::bad)
      EXPECT_NE(y.grade(), naturalness::Grade::bad) << info.key << ": " << x.total << " before, " << y.total << " after";
  }
  expect_small_move(c, motion, *made);
  return report;
}

TEST(NeverWorse, TenFaultsInWalks) {
  Character c = motion_edit::human_walk();
  EXPECT_LT(expect_no_worse("looped", c, c.motion).change_deg, 2);
  c.motion = motion_edit::unrolled(c.m(), c.motion, 3);
  EXPECT_LT(expect_no_worse("unlooped", c, c.motion).change_deg, 2);
  for (const Fault& f : faults()) expect_no_worse(f.name, c, f.plant(c.m(), c.motion));
}

TEST(NeverWorse, TenFaultsInRecordings) {
  if (!motion_edit::has_recordings()) GTEST_SKIP() << "the shared data were not found";
  for (const auto& [skeleton, trial] : {std::pair{"35", "35_01"}, {"02", "02_04"}}) {
    const MeasuredMotion measured = motion_edit::read_recording(skeleton, trial);
    const body::Body body = body::make_body(measured, {}).value();
    Character c{body.mechanism, body::to_motion(body, measured)};
    expect_no_worse(std::string(trial) + " as captured", c, c.motion);
    c.motion = correct_motion(c.m(), c.motion).value();
    EXPECT_LT(expect_no_worse(std::string(trial) + " clean", c, c.motion).change_deg, 2);
    for (const Fault& f : faults()) expect_no_worse(std::string(trial) + " " + f.name, c, f.plant(c.m(), c.motion));
  }
}

// A hovering walk of which the feet move up to 6 cm above the floor has contacts, not flights.
TEST(NeverWorse, HoveringWalks) {
  if (!motion_edit::has_recordings()) GTEST_SKIP() << "the shared data were not found";
  for (const auto& [skeleton, trial] : {std::pair{"07", "07_01"}, {"16", "16_15"}}) {
    const MeasuredMotion measured = motion_edit::read_recording(skeleton, trial);
    const body::Body body = body::make_body(measured, {}).value();
    Character c{body.mechanism, body::to_motion(body, measured)};
    c.motion = correct_motion(c.m(), c.motion).value();
    const CorrectionReport report = expect_no_worse(trial, c, faults().front().plant(c.m(), c.motion));
    EXPECT_EQ(faults().front().name, "floating");
    EXPECT_LT(report.after.residual_bw, 0.05) << trial;
    EXPECT_LT(report.change_deg, 2) << trial;
  }
}

TEST(NeverWorse, KeyedWalks) {
  const Character c{samples::make_person(1.75).value(), {}};
  for (const double travel : {0.0, 0.9, 1.3}) {  // m in a stride of 1 s; the feet need 1.2 to 1.4
    const Motion walk = keyed_walk(c.m(), travel);
    const std::string name = "travel " + std::to_string(travel);
    for (const CorrectionReport& report :
         {expect_no_worse(name + " looped", c, walk), expect_no_worse(name + " unlooped", c, motion_edit::unrolled(c.m(), walk, 4))}) {
      EXPECT_EQ(report.flights, 0) << "sliding feet are no flight";
      EXPECT_LT(report.after.residual_bw, 0.05);
      EXPECT_NEAR(report.travel, travel == 0.0 ? 1.3 : 0, 0.15) << name;
    }
  }
}

TEST(NeverWorse, LoopHasNoSeam) {
  const MechanismPtr person = samples::make_person(1.75).value();
  const auto made = correct_motion(*person, keyed_walk(*person, 0));
  ASSERT_TRUE(made);
  const Motion rounds = motion_edit::unrolled(*person, *made, 2);
  std::vector<double> d(at(person->nv()));
  const auto step = [&](int f) {
    difference(*person, {rounds.frame(f), at(rounds.nq)}, {rounds.frame(f + 1), at(rounds.nq)}, d);
    double sum = 0;
    for (const double x : d) sum += x * x;
    return std::sqrt(sum);
  };
  const int seam = made->frames - 1;
  for (const int f : {seam - 1, seam}) EXPECT_LT(step(f), 1.5 * std::max(step(f - 3), step(f + 3))) << f;
}

TEST(NeverWorse, KeyedJumps) {
  const MechanismPtr person = samples::make_person(1.75).value();
  for (const double rate : {24.0, 30.0, 60.0, 120.0})
    expect_no_worse("tuck jump " + std::to_string(rate), {person, {}}, keyed_tuck_jump(*person, rate));
  const MeasuredMotion standing = samples::make_human_stand();
  const body::Body body = body::make_body(standing, {.keep_unmoved = true}).value();
  const Character c{body.mechanism, body::to_motion(body, standing)};
  for (const auto& [take_off, landing, apex] : {std::array{0.9, 1.7, 0.25}, std::array{0.9, 1.4, 0.3}, std::array{1.0, 1.35, 0.18}})
    expect_no_worse("jump " + std::to_string(apex), c, keyed_jump(c, take_off, landing, apex));
  // Only the height of the root has keys: the feet sink into the floor in the squat.
  const Motion jump = keyed_jump(c, 0.9, 1.4, 0.3);
  Motion rigid = jump;
  for (int f = 0; f < rigid.frames; ++f) {
    std::copy(jump.frame(0), jump.frame(0) + jump.nq, rigid.frame(f));
    rigid.frame(f)[2] = jump.frame(f)[2];
  }
  const CorrectionReport report = expect_no_worse("rigid jump", c, rigid);
  EXPECT_LT(report.after.jerk, 8) << "1000 rad/s^3";
}

TEST(NeverWorse, MotionsOnHandsAndBack) {
  const Character c{samples::make_person(1.75).value(), {}};
  expect_no_worse("get-up", c, keyed_get_up(c.m()));
  expect_no_worse("roll", c, keyed_roll(c.m()));
}

}  // namespace
}  // namespace ugoki::correction
