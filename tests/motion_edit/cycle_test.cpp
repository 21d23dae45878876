#include "ugoki/motion_edit/cycle.h"

#include <gtest/gtest.h>

#include <cmath>

#include "characters.h"
#include "ugoki/motion_edit/edit.h"
#include "ugoki/motion_edit/phase_curve.h"
#include "ugoki/motion_edit/progression.h"
#include "ugoki/motion_edit/rounds.h"

namespace ugoki::motion_edit {
namespace {

/// Maximum acceleration [rad/s^2] of any DOF except the root's, in all frames and at the seam of the cycle: velocity difference between
/// consecutive frames times the frame rate.
struct Steps {
  double anywhere = 0, seam = 0;
};
Steps velocity_steps(const Mechanism& m, const Motion& cycle) {
  const Motion rounds = three_rounds(cycle, m);
  const int n = round_frames(cycle);
  Steps out;
  std::vector<double> v(at(m.nv())), before;
  for (int f = n / 2; f < 2 * n + n / 2; ++f) {
    difference(m, {rounds.frame(f - 1), at(m.nq())}, {rounds.frame(f), at(m.nq())}, v);
    for (std::size_t k = 6; k < v.size() && !before.empty(); ++k) {
      const double step = std::fabs(v[k] - before[k]) * cycle.rate * cycle.rate;
      const bool at_seam = std::abs(f - 1 - n) <= 1 || std::abs(f - 1 - 2 * n) <= 1;
      double& maximum = at_seam ? out.seam : out.anywhere;
      maximum = std::max(maximum, step);
    }
    before = v;
  }
  return out;
}

TEST(Cycle, RepeatedStrideGivesThatStride) {
  for (const Character& character : {human_walk(), dog_trot()}) {
    const Motion walk = unrolled(character.m(), character.motion, 3);
    CycleOptions options;
    options.lock_feet = false;
    CycleReport report;
    const Motion cycle = make_cyclic(character.m(), walk, options, &report).value();
    EXPECT_TRUE(report.by_contacts);
    EXPECT_NEAR(cycle.duration(), character.motion.duration(), 1.5 / cycle.rate);
    EXPECT_TRUE(cycle.cyclic);
    const Placement way = cycle_of(cycle, character.m()), truth = cycle_of(character.motion, character.m());
    EXPECT_NEAR(std::hypot(way.x, way.y), std::hypot(truth.x, truth.y), 0.02);
  }
}

TEST(Cycle, SeamIsContinuousInValueAndVelocity) {
  // A walk with drift: all hinges bend more from frame to frame, so that the ends of a stride differ.
  const Character character = human_walk();
  Motion walk = unrolled(character.m(), character.motion, 3);
  for (int f = 0; f < walk.frames; ++f)
    for (int k = 7; k < walk.nq; ++k) {
      bool is_hinge = false;
      for (const Link& link : character.m().links()) is_hinge = is_hinge || (link.joint.type == JointType::revolute && link.q_index == k);
      if (is_hinge) walk.frame(f)[k] += 0.0006 * f + 0.05 * std::sin(0.05 * f);
    }
  CycleOptions options;
  options.lock_feet = false;
  CycleReport report;
  const Motion cycle = make_cyclic(character.m(), walk, options, &report).value();
  const int n = round_frames(cycle);
  std::vector<double> last(cycle.frame(n), cycle.frame(n) + cycle.nq), d(at(character.m().nv()));
  displace_root(character.m(), inverse(cycle_of(cycle, character.m())), last);
  difference(character.m(), {cycle.frame(0), at(cycle.nq)}, last, d);
  for (const double x : d) EXPECT_LT(std::fabs(x), 1e-12);
  const Steps steps = velocity_steps(character.m(), cycle);
  EXPECT_LT(steps.seam, 1.2 * steps.anywhere + 1);
  // The displacement over the ground is that of the selected frames.
  const Placement way = cycle_of(cycle, character.m());
  const Motion cut = trim(walk, report.first, report.last).value();
  const Placement truth = cycle_of(cut, character.m());
  EXPECT_NEAR(way.x, truth.x, 1e-9);
  EXPECT_NEAR(way.y, truth.y, 1e-9);
  EXPECT_NEAR(way.heading, truth.heading, 1e-9);
}

TEST(Cycle, GivenFramesAreUsedAndChecked) {
  const Character character = human_walk();
  const Motion walk = unrolled(character.m(), character.motion, 2);
  CycleOptions options;
  options.first = 10;
  options.last = 60;
  EXPECT_EQ(make_cyclic(character.m(), walk, options).value().frames, 51);
  options.last = 100000;
  const auto wrong = make_cyclic(character.m(), walk, options);
  ASSERT_FALSE(wrong);
  EXPECT_NE(wrong.error().text().find("100000"), std::string::npos);
  EXPECT_FALSE(make_cyclic(character.m(), trim(walk, 0, 5).value()));
}

TEST(Cycle, WithoutFeetTheCycleIsFoundByPose) {
  // A pendulum with a slow drift.
  MechanismSpec spec;
  spec.name = "pendulum";
  LinkSpec link;
  link.name = "rod";
  link.joint.type = JointType::revolute;
  link.joint.axis = {0, 1, 0};
  link.inertia = Inertia::from_centre(1, {0, 0, -0.5}, {0.1, 0.1, 0.01, 0, 0, 0});
  spec.links = {link};
  const MechanismPtr m = Mechanism::make(spec).value();
  Motion swing;
  swing.name = "swing";
  swing.rate = 100;
  swing.frames = 400;
  swing.nq = 1;
  for (int f = 0; f < 400; ++f) swing.q.push_back(0.5 * std::sin(2 * pi * f / 125.0) + 0.0001 * f);
  CycleReport report;
  const Motion cycle = make_cyclic(*m, swing, {}, &report).value();
  EXPECT_FALSE(report.by_contacts);
  EXPECT_NEAR((cycle.frames - 1) % 125, 0, 2);
  EXPECT_EQ(cycle.frame(0)[0], cycle.frame(cycle.frames - 1)[0]);
}

TEST(Cycle, RecordingsGiveCyclesWithoutSliding) {
  if (!has_recordings()) GTEST_SKIP() << "the shared data is absent";
  for (const auto& [skeleton, trial] : {std::pair{"02", "02_01"}, {"02", "02_03"}, {"35", "35_01"}, {"16", "16_15"}, {"07", "07_01"}}) {
    const MeasuredMotion measured = read_recording(skeleton, trial);
    const body::Body body = body::make_body(measured).value();
    CycleReport report;
    const Motion cycle = make_cyclic(*body.mechanism, body::to_motion(body, measured), {}, &report).value();
    EXPECT_TRUE(report.by_contacts) << trial;
    EXPECT_LT(report.feet.after.worst_cm, 0.6) << trial;
    EXPECT_LT(report.feet.max_miss, 0.003) << trial;
    const Steps steps = velocity_steps(*body.mechanism, cycle);
    EXPECT_LT(steps.seam, 1.5 * steps.anywhere) << trial;
  }
}

TEST(PhaseCurve, IsMonotoneAndInvertible) {
  const PhaseCurve curve({{0.1, 0.0}, {0.35, 0.5}, {0.6, 0.58}, {0.9, 0.8}});
  EXPECT_NEAR(curve(0.35), 0.5, 1e-15);
  EXPECT_NEAR(curve(1.6), 1.58, 1e-15);
  double before = curve(-2), slope_before = 0;
  for (int i = 1; i <= 4000; ++i) {
    const double x = -2 + 0.001 * i, y = curve(x), slope = (y - before) / 0.001;
    EXPECT_GT(y, before);
    if (i > 1) EXPECT_LT(std::fabs(slope - slope_before), 0.2) << "continuous slope at " << x;
    EXPECT_NEAR(curve(curve.inverse(y)), y, 1e-12);
    EXPECT_NEAR(curve(x + 1), y + 1, 1e-12);
    before = y;
    slope_before = slope;
  }
}

TEST(Progression, MakesTheDisplacementOfTheCycle) {
  for (const double turn : {0.0, 1e-7, 0.3, -2.0}) {
    Character character = human_walk();
    // Bend the walk: move every frame to an arc that turns by this angle per cycle.
    const int n = character.motion.frames - 1;
    for (int f = 0; f <= n; ++f) {
      const Placement root = root_placement(character.m(), {character.motion.frame(f), at(character.motion.nq)});
      displace_root(character.m(), inverse(Placement{root.x, root.y, 0, 0}), {character.motion.frame(f), at(character.motion.nq)});
      Progression arc;
      arc.vx = 1.5;
      arc.turn = turn;
      displace_root(character.m(), arc.at(static_cast<double>(f) / n), {character.motion.frame(f), at(character.motion.nq)});
    }
    const Progression p = find_progression(character.motion, character.m());
    const Placement way = cycle_of(character.motion, character.m()), made = p.cycle();
    EXPECT_NEAR(p.turn, turn, 1e-9);
    EXPECT_NEAR(made.x, way.x, 1e-9) << turn;
    EXPECT_NEAR(made.y, way.y, 1e-9) << turn;
    EXPECT_NEAR(std::hypot(p.vx, p.vy), 1.5, 0.05) << turn;
  }
}

}  // namespace
}  // namespace ugoki::motion_edit
