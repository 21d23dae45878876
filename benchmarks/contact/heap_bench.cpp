// Two hundred bodies fall into a heap: processor time per simulated second, and the maximum overlap at any step.

#include <benchmark/benchmark.h>

#include <algorithm>

#include "heap.h"
#include "ugoki/contact/guarded_step.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::benchmarks {

namespace {

MechanismPtr mechanism_of(const HeapBody& b) {
  const double r = b.size[0], h = b.size[1];
  Shape shape = b.shape == HeapShape::box       ? Shape::box({b.size[0], b.size[1], b.size[2]})
                : b.shape == HeapShape::sphere  ? Shape::sphere(r)
                : b.shape == HeapShape::capsule ? Shape::capsule(r, {0, 0, -h}, {0, 0, h})
                                                : Shape::cylinder(r, h);
  shape.friction = heap_friction;
  MechanismSpec spec;
  spec.name = "body";
  LinkSpec link;
  link.name = "body";
  link.joint.type = JointType::floating;
  link.inertia = solid_inertia(shape, b.density);
  link.shapes.push_back(shape);
  spec.links.push_back(link);
  return Mechanism::make(std::move(spec)).value();
}

}  // namespace

HeapResult run_heap(const std::vector<HeapBody>& heap, double dt, int steps) {
  std::vector<MechanismPtr> bodies;
  std::vector<State> states;
  for (const HeapBody& b : heap) {
    bodies.push_back(mechanism_of(b));
    State& s = states.emplace_back(*bodies.back());
    std::copy_n(b.position, 3, s.q.begin());
    std::copy_n(b.orientation, 4, s.q.begin() + 3);
  }
  collision::Scene scene(bodies, collision::Ground{});
  collision::Workspace workspace(scene);
  contact::Stepper stepper(bodies, contact::StepperOptions{});
  contact::GuardedStep guard(scene, stepper);
  std::vector<Pose> poses(bodies.size());
  std::vector<std::span<const Pose>> views;
  std::vector<contact::StepSystem> systems;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    views.emplace_back(&poses[i], 1);
    systems.push_back({states[i].q, states[i].v, states[i].tau, {}, {}, {}});
  }
  std::vector<collision::ContactPoint> contacts;
  HeapResult result;
  for (int i = 0; i < steps; ++i) {
    for (std::size_t k = 0; k < bodies.size(); ++k) calc_poses(*bodies[k], states[k].q, {&poses[k], 1});
    collision::find_contacts(scene, views, 0.02, workspace, contacts);
    for (const collision::ContactPoint& c : contacts) result.deepest = std::max(result.deepest, -c.distance);
    if (guard.step(systems, contacts, dt).status != contact::StepStatus::ok) return {};
  }
  result.measured = true;
  return result;
}

namespace {

using Runner = HeapResult (*)(const std::vector<HeapBody>&, double, int);

void heap(benchmark::State& run, Runner runner) {
  constexpr double dt = 0.002;
  constexpr int steps = 2000;
  const std::vector<HeapBody> bodies = make_heap(200);
  HeapResult result;
  for (auto _ : run) {
    result = runner(bodies, dt, steps);
    if (!result.measured) {
      run.SkipWithError("the engine is not installed, or its simulation diverged");
      return;
    }
  }
  run.counters["per_simulated_second"] =
      benchmark::Counter(static_cast<double>(run.iterations()) * steps * dt, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
  run.counters["deepest_mm"] = 1e3 * result.deepest;
}
BENCHMARK_CAPTURE(heap, ugoki, run_heap)->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK_CAPTURE(heap, bullet, run_bullet_heap)->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK_CAPTURE(heap, mujoco, run_mujoco_heap)->Unit(benchmark::kMillisecond)->Iterations(1);

}  // namespace
}  // namespace ugoki::benchmarks
