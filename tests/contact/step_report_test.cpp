// Reports of steps: contacts that were not solved, substeps, and failed stages of steps.

#include <gtest/gtest.h>

#include "fast.h"

namespace ugoki::contact {
namespace {

/// Two towers of boxes, far apart. Box k of tower t is system 12 t + k. The iteration limit and the tolerance are those of `options`.
struct Towers {
  static constexpr int height = 12;
  World w;

  explicit Towers(const StepperOptions& options) : w(boxes(), {}, options) {
    for (std::size_t i = 0; i < w.states.size(); ++i)
      put(w.states[i], {i < height ? 0.0 : 5.0, 0, 0.1 + 0.2 * static_cast<double>(i % height)});
  }
  static std::vector<MechanismPtr> boxes() {
    std::vector<MechanismPtr> all;
    for (int i = 0; i < 2 * height; ++i) all.push_back(body("box", Shape::box({0.1, 0.1, 0.1}), i % height == height - 1 ? 100000 : 1000));
    return all;
  }
};

TEST(StepReport, IslandsWithResidualAboveToleranceAreCounted) {
  StepperOptions few;
  few.iterations = 1;
  Towers unsolved(few), solved({});
  const StepReport bad = unsolved.w.step(0.002), good = solved.w.step(0.002);
  EXPECT_EQ(bad.not_converged, 2);
  EXPECT_GT(bad.residual, few.tolerance);
  EXPECT_EQ(good.not_converged, 0);
  EXPECT_EQ(good.failures(), 0);
  EXPECT_EQ(good.substeps, 1);
}

TEST(StepReport, RepeatedStepKeepsCountOfIslandsThatItDoesNotSolve) {
  StepperOptions few;
  few.iterations = 1;
  Towers t(few);
  const std::vector<State> begin = t.w.states;
  ASSERT_EQ(t.w.step(0.002).not_converged, 2);
  for (std::size_t i = 0; i < begin.size(); ++i) {
    std::ranges::copy(begin[i].q, t.w.states[i].q.begin());
    std::ranges::copy(begin[i].v, t.w.states[i].v.begin());
  }
  collision::ContactPoint extra = t.w.contacts.front();  // a second contact of the first tower with the ground
  ASSERT_EQ(extra.system_a, 0);
  extra.key += 1000;
  t.w.contacts.push_back(extra);
  const StepReport report = t.w.stepper.repeat(t.w.systems, t.w.contacts, 0.002);
  EXPECT_EQ(report.islands, 1);
  EXPECT_FALSE(t.w.stepper.has_changed(Towers::height));
  EXPECT_GE(report.not_converged, 1) << "the second tower is still not solved";
}

TEST(StepReport, SplitStepReportsItsSubsteps) {
  testing::RandomSource random(3);
  int split = 0;
  for (int i = 0; i < 40; ++i) {
    const double r = random.uniform(0.005, 0.05);
    const MechanismPtr thrown = body("body", any_shape(random, r), 8000);
    Fast f({thrown, body("plate", Shape::box({0.002, 0.5, 0.5}), 500)});
    put(f.w.states[0], {-1, 0.3, 0.2});
    f.w.states[0].v[0] = f.w.states[0].v[1] = 40;
    f.w.states[0].v[3] = 200;
    f.w.states[1].v[1] = 30;
    for (int k = 0; k < 3; ++k) {
      f.step(1.0 / 60);
      ASSERT_GE(f.report.substeps, 1);
      split += f.report.substeps > 1 ? 1 : 0;
    }
  }
  EXPECT_GT(split, 0);
}

/// Two bars of 0.4 m on hinges that are `distance` [m] apart. A loop pins the free ends of the bars to each other.
MechanismPtr pinned_bars(double distance) {
  MechanismSpec spec;
  spec.name = "bars";
  for (const double at : {0.0, distance}) {
    LinkSpec l;
    l.name = at == 0 ? "a" : "b";
    l.joint.type = JointType::revolute;
    l.joint.axis = {0, 1, 0};
    l.joint.X_PJ.p = {at, 0, 0};
    l.inertia = solid_inertia(Shape::capsule(0.03, {0, 0, 0}, {0, 0, 0.4}), 1000);
    spec.links.push_back(l);
  }
  LoopSpec pin;
  pin.name = "pin";
  pin.type = LoopType::revolute;
  pin.link_a = "a";
  pin.link_b = "b";
  pin.X_AJ.p = pin.X_BJ.p = {0, 0, 0.4};
  pin.axis = {0, 1, 0};
  spec.loops.push_back(pin);
  return Mechanism::make(std::move(spec)).value();
}

TEST(StepReport, LoopThatCannotCloseIsOpen) {
  World far({pinned_bars(1)}, {-1000, 0, 0}, {}), near({pinned_bars(0.4)}, {-1000, 0, 0}, {});
  near.states[0].q = {0.5235987755982988, -0.5235987755982988};  // an equilateral triangle
  const StepReport open = far.step(0.002), closed = near.step(0.002);
  EXPECT_EQ(open.open_loops, 1);
  EXPECT_EQ(open.failures(), 1);
  EXPECT_GT(open.loop_gap, 0.19);
  EXPECT_EQ(closed.open_loops, 0);
  EXPECT_LT(closed.loop_gap, 1e-12);
}

TEST(StepReport, ReportsOfSubstepsAreAdded) {
  StepReport a, b;
  a.not_converged = 1;
  a.stops = 2;
  a.residual = 3;
  a.substeps = 5;
  b.not_converged = 4;
  b.failed_motions = 1;
  b.unfinished_impacts = 1;
  b.open_loops = 1;
  b.left_overlaps = 1;
  b.residual = 1;
  b.loop_gap = 0.5;
  b.impacts = 7;
  a.add(b);
  EXPECT_EQ(a.not_converged, 5);
  EXPECT_EQ(a.failures(), 6);
  EXPECT_EQ(a.residual, 3);
  EXPECT_EQ(a.loop_gap, 0.5);
  EXPECT_EQ(a.impacts, 7);
  EXPECT_EQ(a.substeps, 5) << "substeps are counted by the caller";
}

/// A tower at rest begins each step with the impulses of the last one: its contacts keep their keys, and the impulses are kept in world
/// axes, because the tangents of a contact may turn by a right angle when its normal turns slightly.
TEST(StepReport, RestingTowerIsSolvedByItsLastImpulses) {
  const MechanismPtr box = body("box", Shape::box({0.1, 0.1, 0.1}), 500);
  World w(std::vector<MechanismPtr>(10, box), {.height = 0, .friction = 0.8, .restitution = 0}, {});
  for (int i = 0; i < 10; ++i) {
    const Quat turn = exp_map({0, 0, 0.1 * i});
    State& s = w.states[static_cast<std::size_t>(i)];
    put(s, {0, 0, 0.101 + 0.201 * i});
    s.q[3] = turn.w;
    s.q[4] = turn.x;
    s.q[5] = turn.y;
    s.q[6] = turn.z;
  }
  for (int k = 0; k < 300; ++k) w.step(0.002);
  int newton_steps = 0, sweeps = 0;
  for (int k = 0; k < 200; ++k) {
    const StepReport report = w.step(0.002);
    newton_steps += report.newton_steps;
    sweeps += report.sweeps;
    EXPECT_EQ(report.contacts, 40);
  }
  EXPECT_LT(newton_steps, 500) << "in 200 steps";  // 3,000 without them
  EXPECT_LT(sweeps, 1000) << "in 200 steps";
}

}  // namespace
}  // namespace ugoki::contact
