// Inverse and forward dynamics of the figure; each result is checked against the others' before it is timed.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>

#include "figure.h"
#include "ugoki/dynamics/dynamics.h"

namespace ugoki::benchmarks {
namespace {

constexpr Vec3 gravity{0, 0, -9.81};

struct Scene {
  MechanismPtr figure = make_figure();
  State state = lively_state(*figure);
  dynamics::Workspace ws{*figure};
  std::vector<double> out = std::vector<double>(state.v.size());

  void kinematics() { dynamics::update_kinematics(*figure, state.q, state.v, ws); }
};

double difference_of(const std::vector<double>& a, const std::vector<double>& b) {
  double greatest = 0, scale = 1;
  for (std::size_t i = 0; i < a.size(); ++i) {
    greatest = std::max(greatest, std::fabs(a[i] - b[i]));
    scale = std::max(scale, std::fabs(b[i]));
  }
  return greatest / scale;
}

void inverse_dynamics(benchmark::State& run) {
  Scene s;
  for (auto _ : run) {
    s.kinematics();
    dynamics::calc_inverse_dynamics(*s.figure, s.ws, s.state.tau, gravity, {}, s.out);
    benchmark::DoNotOptimize(s.out.data());
  }
}
BENCHMARK(inverse_dynamics);

void inertia_rows(benchmark::State& run) {
  Scene s;
  for (auto _ : run) {
    s.kinematics();
    dynamics::calc_inertia_rows(*s.figure, s.ws);
    benchmark::DoNotOptimize(s.ws.M.data());
  }
}
BENCHMARK(inertia_rows);

using Forward = bool (*)(const Mechanism&, dynamics::Workspace&, std::span<const double>, const Vec3&, std::span<const Vec6>,
                         std::span<double>);

void forward(benchmark::State& run, Forward method) {
  Scene s;
  std::vector<double> reference(s.out.size());
  s.kinematics();
  if (!dynamics::calc_forward_dynamics_by_unit_vectors(*s.figure, s.ws, s.state.tau, gravity, {}, reference) ||
      !method(*s.figure, s.ws, s.state.tau, gravity, {}, s.out) || difference_of(s.out, reference) > 1e-9) {
    run.SkipWithError("disagrees with the unit-vector method");
    return;
  }
  bool ok = true;
  for (auto _ : run) {
    s.kinematics();
    ok = ok && method(*s.figure, s.ws, s.state.tau, gravity, {}, s.out);
    benchmark::DoNotOptimize(s.out.data());
  }
  if (!ok) run.SkipWithError("singular");
}
BENCHMARK_CAPTURE(forward, articulated_body, &dynamics::calc_forward_dynamics);
BENCHMARK_CAPTURE(forward, sparse_factor, &dynamics::calc_forward_dynamics_by_factor);
BENCHMARK_CAPTURE(forward, unit_vectors, &dynamics::calc_forward_dynamics_by_unit_vectors);

}  // namespace
}  // namespace ugoki::benchmarks
