#include "ugoki/world/rollout.h"

#include "ugoki/base/check.h"

namespace ugoki::world {
namespace {

/// Arguments of one call of Rollout::run().
struct Work {
  const World* world;
  std::span<WorldState> states;
  RolloutControls controls;
  int steps;
  double dt;
  std::span<contact::StepReport> reports;

  [[nodiscard]] WorldControl control(std::size_t k, int step) const {
    if (controls.numbers.empty()) return {};
    const std::size_t nv = world->nv(), each = static_cast<std::size_t>(steps) * controls.size;
    const std::size_t first = (controls.numbers.size() == each ? 0 : k * each) + static_cast<std::size_t>(step) * controls.size;
    const std::span<const double> all = controls.numbers.subspan(first, controls.size);
    if (all.size() == nv) return {all, {}, {}};
    return {all.first(nv), all.subspan(nv, nv), all.subspan(2 * nv, nv)};
  }
  void simulate(WorldStepper& stepper, std::size_t k) const {
    contact::StepReport sum;
    sum.substeps = 0;
    stepper.load(states[k]);
    for (int i = 0; i < steps && sum.status == contact::StepStatus::ok; ++i) {
      const contact::StepReport report = stepper.step(control(k, i), dt);
      sum.add(report);
      sum.substeps += report.substeps;
    }
    stepper.store(states[k]);
    reports[k] = sum;
  }
};

}  // namespace

Rollout::Rollout(const World& world, Executor* executor) : world_(&world), executor_(executor) {
  for (int k = 0; k < (executor ? executor->workers() : 1); ++k) steppers_.push_back(std::make_unique<WorldStepper>(world));
}

void Rollout::run(std::span<WorldState> states, const RolloutControls& controls, int steps, double dt,
                  std::span<contact::StepReport> reports) {
  const std::size_t each = static_cast<std::size_t>(steps) * controls.size;
  UGOKI_CHECK(steps >= 0 && dt > 0 && reports.size() == states.size());
  UGOKI_CHECK(controls.numbers.empty() || controls.size == world_->nv() || controls.size == 3 * world_->nv());
  UGOKI_CHECK(controls.numbers.empty() || controls.numbers.size() == each || controls.numbers.size() == states.size() * each);
  const Work work{world_, states, controls, steps, dt, reports};
  parallel_for(executor_, states.size(),
               [&](std::size_t k, int worker) { work.simulate(*steppers_[static_cast<std::size_t>(worker)], k); });
}

}  // namespace ugoki::world
