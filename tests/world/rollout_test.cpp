// Rollouts of many worlds: same bits as one at a time, for every number of threads, without allocations.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "allocation_count.h"
#include "small_worlds.h"
#include "ugoki/plugin/thread_pool.h"
#include "ugoki/world/rollout.h"

namespace ugoki::world {
namespace {

constexpr double dt = 0.002;
constexpr int worlds = 13, steps = 200;

std::vector<WorldState> make_states(const World& world) {
  std::vector<WorldState> states;
  for (int k = 0; k < worlds; ++k) states.push_back(make_state(world, k));
  return states;
}

/// Drive forces and servos that differ for each world and step.
std::vector<double> make_controls(const World& world) {
  const std::size_t nv = world.nv();
  std::vector<double> all;
  for (int k = 0; k < worlds; ++k)
    for (int i = 0; i < steps; ++i)
      for (std::size_t n = 0; n < 3 * nv; ++n) {
        const bool gain = n / nv == 1, root = n % nv < 6;
        all.push_back(gain ? (root ? 0 : 2.0) : std::sin(0.1 * k + 0.01 * i + static_cast<double>(n)) * (n < nv && root ? 0 : 0.5));
      }
  return all;
}

struct Expected {
  std::vector<std::uint64_t> hashes;
  std::vector<contact::StepReport> reports;
};

Expected one_at_a_time(const World& world, const std::vector<double>& controls) {
  Expected out;
  const std::size_t nv = world.nv();
  std::vector<WorldState> states = make_states(world);
  for (int k = 0; k < worlds; ++k) {
    WorldStepper stepper(world);
    contact::StepReport& sum = out.reports.emplace_back();
    sum.substeps = 0;
    WorldState& state = states[static_cast<std::size_t>(k)];
    for (int i = 0; i < steps; ++i) {
      stepper.load(state);  // the state is saved and restored in every step
      const double* c = controls.data() + static_cast<std::size_t>(k * steps + i) * 3 * nv;
      const contact::StepReport report = stepper.step({{c, nv}, {c + nv, nv}, {c + 2 * nv, nv}}, dt);
      sum.add(report);
      sum.substeps += report.substeps;
      stepper.store(state);
    }
    out.hashes.push_back(state.hash());
  }
  return out;
}

TEST(Rollout, HasSameBitsAsWorldsOneAtATimeForEveryNumberOfThreads) {
  const World world = make_world();
  const std::vector<double> controls = make_controls(world);
  const Expected expected = one_at_a_time(world, controls);
  for (const int threads : {1, 2, 8}) {
    plugin::ThreadPool pool(threads);
    Rollout rollout(world, &pool);
    std::vector<WorldState> states = make_states(world);
    std::vector<contact::StepReport> reports(worlds);
    rollout.run(states, {controls, 3 * world.nv()}, steps, dt, reports);
    for (std::size_t k = 0; k < worlds; ++k) {
      EXPECT_EQ(states[k].hash(), expected.hashes[k]) << "world " << k << ", " << threads << " threads";
      EXPECT_EQ(reports[k].status, contact::StepStatus::ok);
      EXPECT_EQ(reports[k].newton_steps, expected.reports[k].newton_steps);
      EXPECT_EQ(reports[k].substeps, expected.reports[k].substeps);
      for (std::size_t other = 0; other < k; ++other) EXPECT_NE(states[k].hash(), states[other].hash());
    }
  }
}

TEST(Rollout, WorldsCanShareControls) {
  const World world = make_world();
  std::vector<double> controls = make_controls(world);
  controls.resize(static_cast<std::size_t>(steps) * 3 * world.nv());
  Rollout rollout(world);
  std::vector<WorldState> states(3, make_state(world, 0));
  std::vector<contact::StepReport> reports(3);
  rollout.run(states, {controls, 3 * world.nv()}, steps, dt, reports);
  EXPECT_EQ(states[0].hash(), one_at_a_time(world, make_controls(world)).hashes[0]);
  EXPECT_EQ(states[1].hash(), states[0].hash());
  EXPECT_EQ(states[2].hash(), states[0].hash());
}

TEST(Rollout, AllocatesNothingAfterPreparation) {
  const World world = make_world();
  const std::vector<double> controls = make_controls(world);
  plugin::ThreadPool pool(2);
  Rollout rollout(world, &pool);
  std::vector<contact::StepReport> reports(worlds);
  // A world may run on another thread in each call; the buffers of this thread then grow to the size that the world needs.
  constexpr int max_runs = 100, quiet_runs = 3;
  int quiet = 0;  // number of successive runs without an allocation, so far
  for (int k = 0; k < max_runs && quiet < quiet_runs; ++k) {
    std::vector<WorldState> states = make_states(world);
    const long before = allocations_so_far();
    rollout.run(states, {controls, 3 * world.nv()}, steps, dt, reports);
    quiet = allocations_so_far() == before ? quiet + 1 : 0;
  }
  EXPECT_EQ(quiet, quiet_runs);
}

TEST(Rollout, WorldWhoseStepFailsKeepsItsStateAndLeavesOthersAlone) {
  const World world = make_world();
  std::vector<double> controls = make_controls(world);
  const Expected expected = one_at_a_time(world, controls);
  const std::size_t each = 3 * world.nv();
  controls[(1 * steps + 50) * each + 8] = std::numeric_limits<double>::quiet_NaN();  // world 1, step 50, a DOF of the puppet
  Rollout rollout(world);
  std::vector<WorldState> states = make_states(world);
  std::vector<contact::StepReport> reports(worlds);
  rollout.run(states, {controls, each}, steps, dt, reports);
  EXPECT_EQ(reports[1].status, contact::StepStatus::not_finite);
  EXPECT_EQ(reports[1].system, puppet);
  for (const double x : states[1].q(puppet)) EXPECT_TRUE(std::isfinite(x));
  for (const double x : states[1].v(puppet)) EXPECT_TRUE(std::isfinite(x));
  for (const std::size_t k : {std::size_t{0}, std::size_t{2}}) EXPECT_EQ(states[k].hash(), expected.hashes[k]);
}

}  // namespace
}  // namespace ugoki::world
