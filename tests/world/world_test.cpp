// States of worlds: saved, restored and copied.

#include <gtest/gtest.h>

#include <algorithm>

#include "allocation_count.h"
#include "small_worlds.h"
#include "ugoki/plugin/thread_pool.h"

namespace ugoki::world {
namespace {

constexpr double dt = 0.002;

void run(WorldStepper& stepper, int steps) {
  for (int i = 0; i < steps; ++i) ASSERT_EQ(stepper.step({}, dt).status, contact::StepStatus::ok) << i;
}

TEST(World, RestoredStateContinuesWithSameBits) {
  const World world = make_world();
  WorldStepper a(world), b(world);
  WorldState now = make_state(world, 3);
  a.load(now);
  run(a, 400);
  a.store(now);
  ASSERT_TRUE(now.is_complete());
  ASSERT_TRUE(std::ranges::any_of(a.forces(), [](const Vec3& f) { return norm(f) > 1; }));
  const WorldState saved = now;
  run(a, 150);
  a.store(now);
  b.load(make_state(world, 7));  // steps from another state must have no effect on the following ones
  run(b, 20);
  b.load(saved);
  run(b, 150);
  WorldState restored(world);
  b.store(restored);
  EXPECT_EQ(restored.hash(), now.hash());
  EXPECT_NE(saved.hash(), now.hash());
}

TEST(World, FreeBallFallsByClosedForm) {
  const World world({make_ball()}, {});
  WorldStepper stepper(world);
  WorldState s(world);
  s.q(0)[2] = 10;
  stepper.load(s);
  run(stepper, 100);
  stepper.store(s);
  EXPECT_NEAR(s.v(0)[5], -9.81 * 0.2, 1e-12);
  EXPECT_NEAR(s.q(0)[2], 10 - 9.81 * dt * dt * 100 * 101 / 2, 1e-12);  // each step moves with the velocity at its end
}

TEST(World, CopiesOfStatesAreEqualAndAllocateNothing) {
  const World world = make_world();
  WorldStepper stepper(world);
  WorldState from = make_state(world, 1), to(world);
  stepper.load(from);
  run(stepper, 200);
  const long before = allocations_so_far();
  stepper.store(from);
  to = from;
  stepper.load(to);
  EXPECT_EQ(allocations_so_far() - before, 0);
  EXPECT_EQ(to.hash(), from.hash());
  EXPECT_TRUE(std::ranges::equal(to.bytes(), from.bytes()));
  to.q(ball)[0] += 1;
  EXPECT_NE(to.hash(), from.hash());
}

TEST(World, LargeWorldHasSameBitsForEveryNumberOfThreads) {
  WorldOptions options;
  options.self_collision = true;
  const World world(std::vector<MechanismPtr>(12, make_puppet()), options);
  ASSERT_GE(world.nv(), contact::min_parallel_dofs);
  WorldState begin(world);
  for (int s = 0; s < 12; ++s) {  // pairs of puppets that fall onto each other
    begin.q(s)[0] = 1.5 * (s / 2);
    begin.q(s)[1] = 0.1 * (s % 2);
    begin.q(s)[2] = 1 + 1.6 * (s % 2);
    begin.v(s)[1] = 0.1 * s;
  }
  const auto simulate = [&](Executor* executor) {
    WorldStepper stepper(world, executor);
    int newton_steps = 0, islands = 0;
    const auto steps = [&](int count) {
      for (int i = 0; i < count; ++i) {
        const contact::StepReport report = stepper.step({}, dt);
        EXPECT_EQ(report.status, contact::StepStatus::ok);
        newton_steps += report.newton_steps;
        islands = std::max(islands, report.islands);
      }
    };
    stepper.load(begin);
    steps(300);
    stepper.load(begin);
    newton_steps = 0;
    const long before = allocations_so_far();
    steps(300);
    if (executor == nullptr || executor->workers() == 1)  // one of several workers may get a larger island than in the warm-up
      EXPECT_EQ(allocations_so_far() - before, 0);
    EXPECT_GE(islands, 6);
    WorldState end(world);
    stepper.store(end);
    return std::pair(end.hash(), newton_steps);
  };
  const auto expected = simulate(nullptr);
  for (const int threads : {1, 2, 8}) {
    plugin::ThreadPool pool(threads);
    EXPECT_EQ(simulate(&pool), expected) << threads << " threads";
  }
}

TEST(World, ServosReachTheirVelocity) {
  WorldOptions options;
  options.stepper.gravity = {};
  const World world({testing::four_bar({}, 1.0, 0).mechanism}, options);
  WorldStepper stepper(world);
  const testing::ClosedCase bars = testing::four_bar({}, 1.0, 0);
  WorldState s(world);
  std::ranges::copy(bars.q, s.q(0).begin());
  stepper.load(s);
  const std::vector<double> none(3), gain = {1e6, 0, 0}, speed = {0.7, 0, 0};
  ASSERT_EQ(stepper.step({none, gain, speed}, dt).status, contact::StepStatus::ok);
  stepper.store(s);
  EXPECT_NEAR(s.v(0)[0], 0.7, 0.01);
}

}  // namespace
}  // namespace ugoki::world
