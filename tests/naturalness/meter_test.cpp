// Measures with closed forms: the parabola of a flight, the shape of a ground force, jerk, work and torque of a pendulum.

#include "ugoki/naturalness/meter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "../motion_edit/characters.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion/contact_labels.h"
#include "ugoki/naturalness/judge_motion.h"
#include "ugoki/naturalness/report_svg.h"

namespace ugoki::naturalness {
namespace {

using enum MeasureId;
using motion_edit::Character;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Total of a measure; negative: it does not apply.
double total(const Report& report, MeasureId id) { return report.measures[index_of(id)].total; }

/// The standing human of the samples, thrown: it falls with `g` [m/s^2] from z = 1 m and slows down by `brake` [m/s^2].
Report thrown(double g, double brake) {
  const Character c = motion_edit::human_walk();
  Motion m = c.motion;
  m.cyclic = false;
  m.contacts.clear();
  m.rate = 120;
  const std::vector<double> pose(c.motion.frame(0), c.motion.frame(0) + m.nq);
  m.q.clear();
  m.frames = 0;
  for (int f = 0; f < 120; ++f) {  // stands, flies from 0.25 s to 0.75 s, stands
    std::vector<double> q = pose;
    const double t = std::clamp(f / 120.0 - 0.25, 0.0, 0.5);
    displace_root(c.m(), {3 * t - brake * t * t / 2, 0, g / 2 * t * (0.5 - t), 0}, q);
    m.q.insert(m.q.end(), q.begin(), q.end());
    ++m.frames;
  }
  return judge_motion(c.m(), m);
}

TEST(Meter, ParabolaOfAFlight) {
  EXPECT_NEAR(total(thrown(9.81, 0), flight_gravity), 0, 0.5);
  EXPECT_NEAR(total(thrown(1.5 * 9.81, 0), flight_gravity), 50, 1);
  EXPECT_NEAR(total(thrown(9.81, 0), flight_speed), 0, 0.5);
  // A speed that decreases by 2 m/s^2 during the fitted time T of the flight
  const double braked = total(thrown(9.81, 2), flight_speed);
  EXPECT_GT(braked, 100 * 2 * 0.3 / 2.5);
  EXPECT_LT(braked, 100 * 2 * 0.5 / 2.4);
}

TEST(Meter, TheGroundCarriesABodyThatLies) {
  const Character c = motion_edit::human_walk();
  Motion m = c.motion;
  m.cyclic = false;
  m.contacts.clear();
  m.frames = 120;
  std::vector<double> q = c.m().neutral();
  const double half = std::sqrt(0.5);
  q[3] = half, q[4] = 0, q[5] = -half, q[6] = 0;  // on the back
  std::vector<Pose> X(c.m().links().size());
  calc_poses(c.m(), q, X);
  double low = 1e9;
  for (std::size_t i = 0; i < X.size(); ++i)
    for (const SupportPoint& p : support_points(c.m().links()[i])) low = std::min(low, (X[i] * p.p).z - p.radius);
  q[2] -= low;
  m.q.clear();
  for (int f = 0; f < m.frames; ++f) m.q.insert(m.q.end(), q.begin(), q.end());
  const Report report = judge_motion(c.m(), m);
  EXPECT_LT(total(report, root_force), 5) << "%";
  EXPECT_LT(total(report, root_moment), 5) << "%";
}

TEST(Meter, ShapeOfAGroundForce) {
  const auto fit = [](double q, double noise) {
    StepSeries force;
    for (int i = 0; i < 200; ++i) {
      const double u = (i + 0.5) / 200 - 0.5;
      force.add(700 * (std::cos(pi * u) - q * std::cos(3 * pi * u)) + (i / 8 % 2 == 0 ? noise : -noise));
    }
    return fit_force(force);
  };
  EXPECT_NEAR(fit(0.4, 0).humps, 0.4, 0.01);
  EXPECT_NEAR(fit(0.0, 0).humps, 0, 0.01);
  EXPECT_LT(fit(0.4, 0).residual, 0.01);
  EXPECT_NEAR(fit(0.2, 100).residual, 100 / (700 * 2 / pi * (1 + 0.2 / 3)), 0.03);
  EXPECT_FALSE(fit_force({}).valid);
}

TEST(Meter, SeriesOfAnyLengthKeepsItsMeans) {
  for (const int n : {10, 47, 48, 500, 5000}) {
    StepSeries s;
    for (int i = 0; i < n; ++i) s.add(i);
    EXPECT_LE(s.size(), StepSeries::room);
    EXPECT_GE(s.size(), std::min(n, StepSeries::room / 2 - 1));
    EXPECT_NEAR(s.values[0], (s.stride - 1) / 2, 1e-9);
    EXPECT_NEAR(s.values[s.size() - 1] - s.values[0], s.stride * (s.size() - 1), 1e-9);
  }
}

/// A pendulum on the world, moved as A sin(w t) by its joint.
TEST(Meter, TorqueWorkAndReasonsOfAFixedArm) {
  LinkSpec arm;
  arm.name = "arm";
  arm.joint.type = JointType::revolute;
  arm.joint.axis = {0, 1, 0};
  arm.joint.dofs[0].effort = 4;
  arm.inertia = Inertia::from_centre(2, {0, 0, -0.5}, Sym3{0.1, 0.1, 0.1, 0, 0, 0});
  const MechanismPtr made = Mechanism::make({"arm", {arm}}).value();
  const Mechanism& m = *made;
  Motion motion;
  motion.rate = 200;
  motion.nq = 1;
  motion.frames = 801;
  for (int f = 0; f < motion.frames; ++f) motion.q.push_back(0.4 * std::sin(2 * pi * f / motion.rate));
  const Report report = judge_motion(m, motion, {.gravity = 0.001});
  // torque = I a with I = 0.1 + 2 * 0.5^2 = 0.6 kg m^2; |torque| > 4 N m while |sin| > 4 / (0.6 * 0.4 * 4 pi^2)
  const double share = 100 * (1 - 2 / pi * std::asin(4 / (0.6 * 0.4 * 4 * pi * pi)));
  EXPECT_NEAR(total(report, torque), share, 4);
  EXPECT_FALSE(report.measures[index_of(torque)].spans.empty());
  for (const MeasureId id : {slip, hover, ground_force, flight_gravity, clearance}) {
    EXPECT_EQ(total(report, id), no_value);
    EXPECT_EQ(report.measures[index_of(id)].reason, "no feet");
  }
  EXPECT_EQ(report.measures[index_of(root_force)].reason, "the root is fixed");
  EXPECT_EQ(report.measures[index_of(tracking)].reason, "only for simulated characters that follow a track");
}

TEST(Meter, AnimalsHaveTheMeasuresThatApply) {
  const Character dog = motion_edit::dog_trot();
  Motion trot = dog.motion;
  trot.cyclic = true;
  const Report report = judge_motion(dog.m(), trot);
  for (const MeasureId id : {slip, penetration, hover, root_force, ground_force, step_symmetry, stance_symmetry, work})
    EXPECT_GE(total(report, id), 0) << info_of(id).name << ": " << report.measures[index_of(id)].reason;
  for (const MeasureId id : {jerk, knee, angular_momentum, force_humps, head_acceleration})
    EXPECT_EQ(report.measures[index_of(id)].reason, "only for two legs");
}

TEST(Meter, ARestoredMeterContinuesWithTheSameBits) {
  const Character c = motion_edit::human_walk();
  const Motion walk = motion_edit::unrolled(c.m(), c.motion, 3);
  Meter a(c.m(), {}), b(c.m(), {});
  std::vector<Pose> X(at(c.m().link_count()));
  std::vector<double> v(at(c.m().nv())), memory(a.memory_size());
  std::vector<std::uint8_t> stance(a.body().feet.size()), touches(a.body().legs.size());
  std::vector<Vec3> forces(touches.size());
  for (int f = 0; f + 1 < walk.frames; ++f) {
    Sample s;
    s.dt = 1 / walk.rate;
    s.q = {walk.frame(f), at(walk.nq)};
    difference(c.m(), s.q, {walk.frame(f + 1), at(walk.nq)}, v);
    for (double& x : v) x *= walk.rate;
    s.v = s.torque = v;
    calc_poses(c.m(), s.q, X);
    s.X_WB = s.reference = X;
    for (std::size_t k = 0; k < touches.size(); ++k) {
      touches[k] = (f / 30 + static_cast<int>(k)) % 2 == 0 ? 1 : 0;
      forces[k] = {0, 0, touches[k] ? 700.0 : 0.0};
    }
    s.stance = stance;
    s.stands = s.touches = touches;
    s.forces = forces;
    if (f == 100) {
      a.save(memory);
      b.restore(memory);
    }
    a.add(s);
    if (f >= 100) b.add(s);
  }
  const auto x = a.totals(), y = b.totals();
  for (std::size_t k = 0; k < measure_count; ++k) {
    EXPECT_EQ(x[k], y[k]) << measure_list()[k].name;
    EXPECT_EQ(a.now(static_cast<MeasureId>(k)), b.now(static_cast<MeasureId>(k)));
  }
}

TEST(Report, BadSpansAreJoinedAndHaveTheirWorstValue) {
  const Limits limits{5, 10, 20, 30};
  const std::vector<double> values = {15, 31, 40, 15, 35, no_value, 15, 15, 15, 15, 4, 2, 15};
  const std::vector<BadSpan> spans = find_bad_spans(values, limits, 20);
  ASSERT_EQ(spans.size(), 2u);
  EXPECT_NEAR(spans[0].from, 0.05, 1e-12);
  EXPECT_NEAR(spans[0].to, 0.25, 1e-12);
  EXPECT_EQ(spans[0].value, 40);
  EXPECT_EQ(spans[1].value, 2);
  EXPECT_EQ(grade(limits, 25), Grade::fair);
  EXPECT_EQ(grade(limits, no_value), Grade::none);
}

TEST(Report, PicturesShowCurvesAndBadSpans) {
  const Character c = motion_edit::human_walk();
  Report report = judge_motion(c.m(), c.motion);
  report.name = "a <walk>";
  report.measures[index_of(slip)].spans = {{0.5, 0.7, 0.6, 4}};
  const std::string all = report_svg({&report, 1}), one = measure_svg(report, slip);
  for (const std::string& svg : {all, one}) {
    EXPECT_TRUE(svg.starts_with("<svg"));
    EXPECT_TRUE(svg.ends_with("</svg>\n"));
    EXPECT_NE(svg.find("a &lt;walk&gt;"), std::string::npos);
    EXPECT_NE(svg.find("class=\"bad\""), std::string::npos);
    EXPECT_NE(svg.find("<polyline"), std::string::npos);
    EXPECT_EQ(svg.find("nan"), std::string::npos);
  }
  EXPECT_NE(all.find("Foot skate"), std::string::npos);
}

TEST(MeasureList, KeysAreUniqueAndLimitsAreOrdered) {
  for (const MeasureInfo& info : measure_list()) {
    EXPECT_EQ(find_measure(info.key), &info);
    EXPECT_EQ(&info_of(info.id), &info);
    for (const Limits& l : {info.limits, info.now})
      EXPECT_TRUE(l.low <= l.good_low && l.good_low <= l.good_high && l.good_high <= l.high) << info.name;
  }
  EXPECT_EQ(find_measure("charm"), nullptr);
  for (int r = 0; r <= static_cast<int>(Reason::no_walk); ++r) EXPECT_FALSE(reason_words(value_of(static_cast<Reason>(r))).empty());
  EXPECT_EQ(reason_words(0), "");
}

}  // namespace
}  // namespace ugoki::naturalness
