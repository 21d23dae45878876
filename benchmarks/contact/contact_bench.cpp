// Times of complete steps of 2 ms: collision analysis, collision force and dynamics.

#include <benchmark/benchmark.h>

#include <array>
#include <vector>

#include "character.h"
#include "ugoki/collision/scene.h"
#include "ugoki/contact/stepper.h"

namespace ugoki::benchmarks {
namespace {

constexpr double dt = 0.002;

/// The character above the ground, held in its pose by servos or without drives.
struct World {
  MechanismPtr character = make_character();
  State state = standing_state(*character);
  collision::Scene scene{{character}, collision::Ground{}};
  collision::Workspace workspace{scene};
  contact::Stepper stepper{{character}, contact::StepperOptions{}};
  std::vector<Pose> poses = std::vector<Pose>(static_cast<std::size_t>(character->link_count()));
  std::vector<collision::ContactPoint> contacts;
  std::vector<double> gain, rest = std::vector<double>(state.v.size());
  std::size_t contact_count = 0;

  explicit World(double stiffness) : gain(state.v.size(), stiffness) {
    std::fill_n(gain.begin(), 6, 0.0);
    contacts.reserve(256);
  }

  bool step() {
    calc_poses(*character, state.q, poses);
    const std::array<std::span<const Pose>, 1> all = {poses};
    collision::find_contacts(scene, all, 0.02, workspace, contacts);
    contact_count += contacts.size();
    std::array<contact::StepSystem, 1> systems = {{{state.q, state.v, state.tau, {}, gain, rest}}};
    return stepper.step(systems, contacts, dt).status == contact::StepStatus::ok;
  }
};

/// Measures one simulated second from the standing pose, repeatedly. With stiff joints the character stays upright; without drives it
/// falls.
void one_second(benchmark::State& run, double stiffness, double lowest_pelvis, double highest_pelvis) {
  World world(stiffness);
  const State begin = world.state;
  std::size_t steps = 0;
  bool ok = true;
  for (auto _ : run) {
    world.state = begin;
    for (int i = 0; i < 500; ++i) ok = ok && world.step();
    steps += 500;
    ok = ok && world.state.q[2] > lowest_pelvis && world.state.q[2] < highest_pelvis;
  }
  if (!ok) run.SkipWithError("the character did not stand (stiff) or fall (limp) as expected");
  const auto count = static_cast<double>(steps);
  run.counters["step"] = benchmark::Counter(count, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
  run.counters["faster_than_real_time"] = benchmark::Counter(count * dt, benchmark::Counter::kIsRate);
  run.counters["contacts"] = static_cast<double>(world.contact_count) / count;
}
BENCHMARK_CAPTURE(one_second, stands, 500.0, 0.9, 1.0)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(one_second, collapses, 0.0, 0.0, 0.7)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace ugoki::benchmarks
