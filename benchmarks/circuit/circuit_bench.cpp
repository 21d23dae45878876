// What a tick costs for each LSI: a chain of adders, as a circuit and as virtual calls on objects.

#include <benchmark/benchmark.h>

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "ugoki/circuit/interpreter.h"
#include "ugoki/circuit/signal_lsis.h"

namespace ugoki::circuit {
namespace {

const Library& library() {
  static const Library all = [] {
    Library l;
    add_signal_lsis(l);
    return l;
  }();
  return all;
}

/// one -> add -> add -> ...: the last output is n + 1.
Circuit chain(int n) {
  Circuit c;
  c.name = "chain";
  c.lsis.push_back({.id = "one", .type = "constant", .label = {}, .note = {}, .at = {}, .parameters = {{"value", 1.0}}, .values = {}});
  for (int i = 0; i < n; ++i) {
    const std::string id = "a" + std::to_string(1000000 + i);
    c.lsis.push_back({.id = id, .type = "add", .label = {}, .note = {}, .at = {}, .parameters = {}, .values = {{"b", 1.0}}});
    c.wires.push_back({i ? "a" + std::to_string(1000000 + i - 1) + ".out" : "one.out", id + ".a"});
  }
  return c;
}

void run_chain(benchmark::State& state, bool check, Interpreter::Clock clock) {
  const int n = static_cast<int>(state.range(0));
  auto interpreter = Interpreter::build(chain(n), library(), nullptr, {.dt = 0.001, .check_finite = check});
  if (!interpreter) return state.SkipWithError("the circuit was refused");
  interpreter->set_timing(clock);
  for (auto _ : state) benchmark::DoNotOptimize(interpreter->tick());
  const auto last = interpreter->find_output("a" + std::to_string(1000000 + n - 1) + ".out");
  if (!last || last->numbers()[0] != n + 1) state.SkipWithError("the result is wrong");
  state.counters["ns_per_lsi"] =
      benchmark::Counter(static_cast<double>(n), benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void circuit_plain(benchmark::State& state) { run_chain(state, false, nullptr); }
void circuit_checked(benchmark::State& state) { run_chain(state, true, nullptr); }
void circuit_timed(benchmark::State& state) {
#if defined(__x86_64__)
  run_chain(state, true, []() -> std::uint64_t { return __builtin_ia32_rdtsc(); });
#else
  run_chain(state, true,
            []() -> std::uint64_t { return static_cast<std::uint64_t>(std::chrono::steady_clock::now().time_since_epoch().count()); });
#endif
}

struct Part {
  virtual ~Part() = default;
  virtual void step() = 0;
};
struct Adder final : Part {
  const double* a = nullptr;
  double b = 1, out = 0;
  void step() override { out = *a + b; }
};

void virtual_calls(benchmark::State& state) {
  const int n = static_cast<int>(state.range(0));
  const double one = 1;
  std::vector<std::unique_ptr<Part>> parts;
  const double* from = &one;
  for (int i = 0; i < n; ++i) {
    auto adder = std::make_unique<Adder>();
    adder->a = from;
    from = &adder->out;
    parts.push_back(std::move(adder));
  }
  for (auto _ : state) {
    for (const auto& p : parts) p->step();
    benchmark::ClobberMemory();
  }
  if (*from != n + 1) state.SkipWithError("the result is wrong");
  state.counters["ns_per_lsi"] =
      benchmark::Counter(static_cast<double>(n), benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

BENCHMARK(circuit_plain)->Arg(1)->Arg(100)->Arg(1000)->Arg(10000);
BENCHMARK(circuit_checked)->Arg(1)->Arg(100)->Arg(1000)->Arg(10000);
BENCHMARK(circuit_timed)->Arg(1)->Arg(100)->Arg(1000)->Arg(10000);
BENCHMARK(virtual_calls)->Arg(1)->Arg(100)->Arg(1000)->Arg(10000);

}  // namespace
}  // namespace ugoki::circuit
