#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "balance_scene.h"

namespace ugoki::control {
namespace {

TEST(BalanceControl, WalksWithoutAssist) {
  const Walker w;
  Simulation s(w.body, w.walk, 20);
  double worst = 0, error = 0;
  const int steps = 4000;
  for (int i = 0; i < steps; ++i) {
    s.step();
    if (HasFatalFailure()) return;
    worst = std::max(worst, s.below());
    error += s.tracking_error() / steps;
    ASSERT_TRUE(s.last.solved);
  }
  EXPECT_LT(worst, 0.05);
  EXPECT_LT(error, 4);
  EXPECT_GT(s.state.q[0], 0.8 * 1.35 * 8);  // m: the walk has a speed of 1.35 m/s
}

TEST(BalanceControl, IsTheSameAtAnotherPlaceAndHeading) {
  const Walker walker;
  const auto walk = std::make_shared<const Looped>(walker.body.mechanism, motion_of(walker.body, walker.walk), 60);
  const Placement by{50, -20, 0, 0.65};
  Simulation here(walker.body.mechanism, walk),
      there(walker.body.mechanism, std::make_shared<const Displaced>(walker.body.mechanism, walk, by));
  std::vector<double> moved, difference_of(here.state.v.size());
  for (int k = 0; k < 1500; ++k) {
    // A push to the side and ahead in one step, relative to the character
    const Vec3 push = k >= 500 && k < 550 ? Vec3{80, 60, 0} : Vec3{};
    here.step(push);
    there.step(rotation_about({0, 0, 1}, by.heading) * push);
    EXPECT_NEAR(here.tracking_error(), there.tracking_error(), 1e-3) << "tick " << k;
    if (HasFailure()) break;
  }
  moved = here.state.q;
  displace_root(*here.m, by, moved);
  difference(*here.m, moved, there.state.q, difference_of);
  for (const double d : difference_of) EXPECT_NEAR(d, 0, 1e-4);
}

TEST(BalanceControl, StepsAfterAPushAndWalksOn) {
  const Walker w;
  for (const Vec3& direction : {Vec3{1, 0, 0}, Vec3{-1, 0, 0}}) {
    Simulation s(w.body, w.walk, 20);
    const Vec3 push = direction * (0.3 * s.m->mass() / 0.2);  // 0.3 N s/kg within 0.2 s
    double shift = 0;
    for (int i = 0; i < 3500; ++i) {
      s.step(i >= 1000 && i < 1100 ? push : Vec3{});
      if (HasFatalFailure()) return;
      for (const BalanceState::FootState& f : s.memory.feet)
        if (i > 1000) shift = std::max(shift, std::hypot(f.shift[0], f.shift[1]));
      ASSERT_LT(s.below(), 0.3) << "time " << 0.002 * i;
    }
    EXPECT_GT(shift, 0.1);
    EXPECT_LT(s.below(), 0.05);
  }
}

TEST(BalanceControl, PlannedAccelerationsAreMet) {
  // The quadratic program plans forces at the touching points. The contact step finds forces by complementarity. The two agree while the
  // contacts do not change.
  const Walker w;
  Simulation s(w.body, w.walk, 20);
  std::vector<double> misses;
  for (int i = 0; i < 1000; ++i) {
    const std::vector<double> before = s.state.v;
    s.step();
    if (HasFatalFailure()) return;
    double miss = 0;
    for (std::size_t k = 0; k < 6; ++k) miss = std::max(miss, std::fabs((s.state.v[k] - before[k]) / 0.002 - s.control.wanted()[k]));
    misses.push_back(miss);
  }
  std::ranges::sort(misses);
  EXPECT_LT(misses[misses.size() / 2], 1.0);  // m/s^2, rad/s^2, of the root
}

TEST(BalanceControl, PlanKeepsTorqueLimits) {
  // With weak drives the program plans accelerations that the drives can produce, so that no torque is clamped afterwards.
  Walker w;
  MechanismSpec spec = w.body.mechanism->spec();
  for (LinkSpec& l : spec.links)
    for (Dof& d : l.joint.dofs) d.effort *= 0.35;
  w.body.mechanism = Mechanism::make(std::move(spec)).value();
  Simulation s(w.body, w.walk, 20);
  std::vector<double> misses;
  for (int i = 0; i < 1000; ++i) {
    const std::vector<double> before = s.state.v;
    s.step();
    if (HasFatalFailure()) return;
    if (s.last.limits == 0) continue;
    double miss = 0;
    for (std::size_t k = 0; k < 6; ++k) miss = std::max(miss, std::fabs((s.state.v[k] - before[k]) / 0.002 - s.control.wanted()[k]));
    misses.push_back(miss);
  }
  ASSERT_GT(misses.size(), 20u);
  std::ranges::sort(misses);
  EXPECT_LT(misses[misses.size() / 2], 1.0);  // m/s^2, rad/s^2, of the root
}

TEST(BalanceControl, SameBitsAfterRestore) {
  const Walker w;
  Simulation s(w.body, w.walk, 20), t(w.body, w.walk, 20);
  for (int i = 0; i < 400; ++i) s.step();
  t.state.q = s.state.q;
  t.state.v = s.state.v;
  t.memory = s.memory;
  t.stepper.set_warm(s.stepper.warm());
  for (int i = 0; i < 400; ++i) {
    s.step();
    t.step();
  }
  EXPECT_EQ(s.state.q, t.state.q);
  EXPECT_EQ(s.state.v, t.state.v);
}

TEST(FootSchedule, FindsTheStancesOfAWalk) {
  const Walker w;
  const Motion motion = motion_of(w.body, w.walk);
  const auto reference = std::make_shared<const Looped>(w.body.mechanism, motion, 45);  // s; the schedule works in parts of 20 s
  const std::vector<Foot> feet = feet_of(*w.body.mechanism);
  ASSERT_EQ(feet.size(), 2u);
  const FootSchedule schedule(*w.body.mechanism, feet, *reference, 0);
  const double cycle = motion.duration();
  for (std::size_t f = 0; f < 2; ++f) {
    EXPECT_NEAR(static_cast<double>(schedule.stances(f).size()), 45 / cycle, 1.5);
    for (const Stance& s : schedule.stances(f)) {
      if (!std::isfinite(s.begin) || !std::isfinite(s.end) || s.begin == 0) continue;
      EXPECT_NEAR((s.end - s.begin) / cycle, 0.62, 0.08);  // a foot of a walking human stands for about 62 % of a stride
    }
  }
  for (double t = 0; t < 45; t += 0.1) EXPECT_TRUE(schedule.at(0, t).stands || schedule.at(1, t).stands) << t;
}

}  // namespace
}  // namespace ugoki::control
