// Cost [ns] of one LSI (function block of a circuit) that adds two values. The LSI is in a library behind the C interface; the circuit
// checks that results are finite and records the running LSI. Compared with virtual calls on objects and a flow graph of oneTBB.

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "allocation_count.h"
#include "table.h"
#include "tbb_chain.h"
#include "ugoki/circuit/activity.h"
#include "ugoki/circuit/interpreter.h"
#include "ugoki/plugin/load.h"

namespace ugoki::benchmarks {
namespace {

using circuit::Circuit;
using circuit::Interpreter;

std::string id(int i) { return "a" + std::to_string(1000000 + i); }

/// A chain add -> add -> ...: each LSI adds 1 to the output of the previous one, so that the last one outputs n.
Circuit chain(int n) {
  Circuit c;
  c.name = "chain";
  for (int i = 0; i < n; ++i) {
    circuit::Instance lsi;
    lsi.id = id(i);
    lsi.type = "adder/add";
    lsi.values = {{"b", 1.0}};
    if (i == 0) lsi.values.push_back({"a", 0.0});
    c.lsis.push_back(std::move(lsi));
    if (i) c.wires.push_back({id(i - 1) + ".out", id(i) + ".a"});
  }
  return c;
}

struct Part {
  virtual ~Part() = default;
  virtual void step() = 0;
};
struct Adder final : Part {
  const double *a = nullptr, *b = nullptr;
  double out = 0;
  void step() override { out = *a + *b; }
};

struct VirtualChain {
  explicit VirtualChain(int n) {
    const double* from = &zero;
    for (int i = 0; i < n; ++i) {
      auto adder = std::make_unique<Adder>();
      adder->a = from;
      adder->b = &one;
      from = &adder->out;
      parts.push_back(std::move(adder));
    }
    last = from;
  }
  void tick() const {
    for (const auto& p : parts) p->step();
    __asm__ volatile("" ::: "memory");
  }
  double zero = 0, one = 1;
  std::vector<std::unique_ptr<Part>> parts;
  const double* last = nullptr;
};

void require(bool good, const std::string& what) {
  if (!good) throw std::runtime_error(what);
}

void rows(Table& table) {
  Result<plugin::LoadedLibrary> loaded = plugin::load_library(UGOKI_ADDER);
  require(loaded.has_value(), loaded ? "" : loaded.error().text());
  circuit::Library library;
  for (const circuit::LsiClass& c : loaded->classes) library.add(c);
  circuit::Activity activity;
  for (const int n : {1, 100, 1000, 10000}) {
    std::vector<Interpreter> ours;  // three interpreters: without probes, with probes, with timing
    for (int i = 0; i < 3; ++i) {
      Result<Interpreter> made = Interpreter::build(chain(n), library, nullptr, {.dt = 0.001, .check_finite = true, .activity = &activity});
      require(made.has_value(), made ? "" : made.error().text());
      ours.push_back(std::move(*made));
    }
    std::vector<std::string> pins;
    for (int i = 0; i < n; ++i) pins.push_back(id(i) + ".out");
    require(ours[1].set_probes(pins, 64).has_value(), "the probes were refused");
    ours[2].set_timing(&Interpreter::processor_clock, 4);  // as the studio does it
    const VirtualChain virtuals(n);
    TbbChain flow(n);

    for (Interpreter& i : ours) i.tick();
    virtuals.tick();
    for (Interpreter& i : ours) require(i.find_output(id(n - 1) + ".out")->numbers()[0] == n, "the circuit's result is wrong");
    require(*virtuals.last == n && flow.tick() == n, "a peer's result is wrong");
    const long before = allocations_so_far();
    for (Interpreter& i : ours)
      for (int k = 0; k < 200; ++k) i.tick();
    require(allocations_so_far() == before, "a tick allocated");

    // Several ticks per call, as a host runs them for each displayed frame.
    constexpr int ticks = 16;
    std::vector<double> ns = measure({[&] { ours[0].run(ticks); }, [&] { ours[1].run(ticks); }, [&] { ours[2].run(ticks); },
                                      [&] {
                                        for (int i = 0; i < ticks; ++i) virtuals.tick();
                                      },
                                      [&] {
                                        for (int i = 0; i < ticks; ++i) flow.tick();
                                      }},
                                     0.3);
    for (double& x : ns) x /= ticks;
    const std::string size = ", " + std::to_string(n) + (n == 1 ? " LSI" : " LSIs");
    table.add({"dispatch" + size, ns[0] / n, "virtual call", ns[3] / n});
    table.add({"dispatch" + size, ns[0] / n, "oneTBB flow graph", ns[4] / n});
    table.add({"dispatch, every output probed" + size, ns[1] / n, "virtual call", ns[3] / n});
    table.add({"dispatch, every LSI timed in one tick of four" + size, ns[2] / n, "virtual call", ns[3] / n});
    if (n == 1000) table.add({"a tick of 1000 LSIs", ns[0], "virtual calls", ns[3], 1000});
  }
}

const RowRegistration registration(100, rows);

}  // namespace
}  // namespace ugoki::benchmarks
