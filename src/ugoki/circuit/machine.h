#pragma once
// The form that runs: one arena, calls with bound addresses, lists of jobs. Private to the interpreter.

#include <memory>
#include <string>
#include <vector>

#include "ugoki/circuit/interpreter.h"
#include "ugoki/circuit/plan.h"

namespace ugoki::circuit {

/// One call of a schedule.
struct Job {
  StepFunction run = nullptr;
  const Call* call = nullptr;
  const double* check = nullptr;  ///< numbers it writes, to be finite
  std::uint32_t check_count = 0;
  std::uint32_t every = 1;
  int lsi = 0;
};

/// Where a part of the arena lies, bytes.
struct Range {
  std::size_t begin = 0, end = 0;
  [[nodiscard]] std::size_t size() const { return end - begin; }
};

struct Unit {
  std::string id;
  const LsiClass* lsi_class = nullptr;
  std::uint32_t every = 1;
  std::vector<Shape> outputs;
  std::vector<std::size_t> output_offsets;  ///< in the arena, where consumers read
  Range state;
  Range direct_numbers, delayed_numbers;  ///< numeric outputs to check; delayed ones where the LSI writes
  std::size_t parameters = 0;             ///< first one in Machine::parameters
  std::uint64_t runs = 0, total = 0;      ///< timing
};

struct Interpreter::Machine {
  ~Machine();

  std::vector<Unit> units;      ///< [lsis], sorted by id
  std::vector<Call> calls;      ///< [lsis]
  std::vector<const void*> in;  ///< of all calls
  std::vector<void*> out;
  std::vector<std::uint32_t> in_first, in_count, out_count;
  std::vector<double> parameters;
  std::vector<std::uint64_t> arena;  ///< in words of 8 bytes
  Range front, back;                 ///< delayed outputs: as seen, as written; same order
  std::vector<Job> steps, advances, on_demand;
  std::vector<int> order;
  std::vector<FlatPort> inputs, outputs;
  std::uint64_t layout = 0;  ///< hash of ids, classes, versions and sizes
  Tick tick;
  Clock clock = nullptr;
  bool is_stopped = false;
  Stop stop;
  char reason[256] = {};

  [[nodiscard]] std::byte* bytes() { return reinterpret_cast<std::byte*>(arena.data()); }
  [[nodiscard]] const std::byte* bytes() const { return reinterpret_cast<const std::byte*>(arena.data()); }
  void initialise();
  template <bool timed>
  bool run(std::vector<Job>& jobs);
  void fail(const Job& job, bool not_finite);
  [[nodiscard]] int find_unit(std::string_view id) const;
  [[nodiscard]] PinView view(const Source& source) const;
  void store_objects();
  void recall_objects();
};

/// Lays out the arena and binds all addresses. @param problems gets what `make` of an LSI refuses
[[nodiscard]] std::unique_ptr<Interpreter::Machine> make_machine(FlatCircuit flat, Plan plan, const BuildOptions& options, Error& problems);

}  // namespace ugoki::circuit
