#pragma once
// Executable form of a circuit: one arena (memory of all values), calls with bound addresses, lists of jobs. Private to the interpreter.

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "ugoki/circuit/activity.h"
#include "ugoki/circuit/arena.h"
#include "ugoki/circuit/interpreter.h"
#include "ugoki/circuit/plan.h"

namespace ugoki::circuit {

/// One call of a schedule: the step or the advance of an LSI.
struct Job {
  StepFunction run = nullptr;
  Call* call = nullptr;
  const RunningLsi* who = nullptr;
  const double* check = nullptr;  ///< first of the numbers that the job writes and that must be finite; null: unchecked
  std::uint32_t check_count = 0;
  std::uint32_t every = 1;  ///< the job runs at each `every`-th tick
  std::uint32_t lsi = 0;    ///< index of the LSI in Machine::units
};

/// Independent jobs, as indices into Machine::wave_jobs: [begin, own_end) are of built-in LSIs, [own_end, end) of plug-ins.
struct Wave {
  std::uint32_t begin = 0, own_end = 0, end = 0;
};

/// A part of the arena, given by offsets in bytes.
struct Range {
  std::size_t begin = 0, end = 0;
  [[nodiscard]] std::size_t size() const { return end - begin; }
};

/// One LSI of the running circuit.
struct Unit {
  std::string id;
  const LsiClass* lsi_class = nullptr;
  std::uint32_t every = 1;
  std::vector<Shape> outputs;
  std::vector<std::size_t> output_offsets;  ///< for each output: offset in the arena, bytes, of the payload that consumers read
  Range state;
  Range direct_numbers, delayed_numbers;  ///< memory of numeric outputs that is checked to be finite (delayed ones in Machine::back)
  std::size_t parameters = 0;             ///< index of the LSI's first parameter in Machine::parameters
  std::string address;                    ///< value of the LSI's first text or choice parameter, which a device uses; empty: none
};

/// A guard word before or after the memory that an LSI of an installed library writes. A changed word proves that the LSI wrote outside
/// its own memory.
struct Fence {
  static constexpr std::uint64_t intact = 0x5AFE5AFE5AFE5AFE;  // finite as a double, because the check for finite numbers includes fences
  enum class Side : std::uint8_t { before_outputs, after_output, before_state, after_state };
  std::size_t at = 0;  ///< offset in the arena, bytes
  std::uint32_t lsi = 0, pin = 0;
  Side side = Side::after_output;
};

struct ProbeBuffer {
  std::vector<const double*> sources;  ///< addresses of the `width` numbers to copy at the end of a tick
  std::vector<double> rows;            ///< samples: [capacity][width]
  std::vector<std::uint64_t> ticks;
  std::uint64_t written = 0;  ///< number of rows written so far, including overwritten ones
  std::size_t next = 0;       ///< index of the row to write next
  std::uint32_t every = 1;

  [[nodiscard]] std::size_t width() const { return sources.size(); }
};

struct ActiveBreakpoint {
  Breakpoint condition;
  const double* number = nullptr;
  double last = 0;     ///< value of the number at the previous tick
  bool armed = false;  ///< for Comparison::changed: `last` is set; for others: the condition was false at the previous tick
};

/// A value that the host writes: an input of the circuit or an output of a device.
struct RecordedSlot {
  std::string name;
  std::span<std::byte> now;       ///< the value's payload in the arena
  std::vector<std::byte> before;  ///< the value's payload at the previous tick
};

struct InputLog {
  std::vector<RecordedSlot> slots;
  std::vector<InputChange> changes;  ///< changes recorded so far
  bool recording = false;
  std::vector<InputChange> replay;  ///< changes to apply, sorted by tick
  std::size_t next = 0;             ///< index into `replay` of the next change to apply
};

struct Interpreter::Machine {
  ~Machine();

  std::vector<Unit> units;             ///< all LSIs, sorted by id; the index of an LSI is its index in this vector
  std::vector<RunningLsi> running;     ///< by index of the LSI: description of the LSI for `activity`
  std::vector<Call> calls;             ///< arguments of the functions of all LSIs, in the order of the schedule
  std::vector<std::uint32_t> call_of;  ///< by index of the LSI: index of the LSI's call in `calls`
  std::vector<const void*> in;         ///< input addresses of all calls; each call points into this vector and the next five
  std::vector<void*> out;
  std::vector<std::uint32_t> in_first, in_count, out_count;
  std::vector<double> parameters;
  Arena arena;
  std::vector<Fence> fences;
  std::vector<std::uint32_t> foreign;  ///< indices into `units` of the LSIs of installed libraries
  Range front, back;                   ///< delayed outputs: consumers read `front`, LSIs write `back`; both have the same layout
  std::vector<Job> jobs;               ///< calls of a tick: all `step` calls, then all `advance` calls
  std::size_t step_count = 0;          ///< number of steps at the beginning of `jobs`
  std::vector<Job> on_demand;
  std::vector<std::uint32_t> wave_ends;  ///< for each depth (plan.h): end index in `jobs` of the steps of this depth
  std::vector<int> order;                ///< indices of LSIs in the order in which their steps run
  std::vector<FlatPort> inputs, outputs;
  std::uint64_t layout = 0;               ///< hash of ids, classes, versions and sizes
  Tick tick{};                            ///< index and time of the current tick
  std::vector<std::uint32_t> slow_rates;  ///< all values of `every` above 1, sorted
  std::vector<Tick> slow_ticks;           ///< for each of `slow_rates`: copy of `tick` with dt multiplied by the rate
  Activity* activity = nullptr;
  Activity own_activity;  ///< used if BuildOptions::activity is null

  // Optional features; they cost nothing while they are off.
  bool plain = true;  ///< true: all optional features are off
  bool fast = true;   ///< true: only timing and probes at each tick may be on, so that run_fast can run
  Clock clock = nullptr;
  std::uint32_t timed_one_in = 1;
  std::uint64_t timed_ticks = 0;
  std::vector<Timing> timings;  ///< by index of the LSI: its times; the ids are empty
  Executor* executor = nullptr;
  std::vector<std::vector<char>> reasons;  ///< for each worker: buffer for Call::reason
  std::vector<Job> wave_jobs;              ///< copies of `jobs`, grouped by `waves`
  std::vector<Wave> waves;
  ProbeBuffer probes;
  std::vector<ActiveBreakpoint> breakpoints;
  int breakpoint_hit = -1;
  InputLog log;
  std::uint32_t cursor = 0;  ///< number of jobs of the current tick that step_lsi has run

  bool is_stopped = false;
  Stop stop;
  char reason[512] = {};

  [[nodiscard]] std::byte* bytes() { return reinterpret_cast<std::byte*>(arena.data()); }
  [[nodiscard]] const std::byte* bytes() const { return reinterpret_cast<const std::byte*>(arena.data()); }
  [[nodiscard]] Call& call_at(std::size_t lsi) { return calls[call_of[lsi]]; }
  /// The tick given to LSIs that run at each `every`-th tick: its dt is the time between two runs of such an LSI.
  [[nodiscard]] const Tick& tick_of(std::uint32_t every) const;
  void set_tick(std::uint64_t index);
  void initialise();
  void set_fences();
  [[nodiscard]] bool are_fences_intact();
  [[nodiscard]] bool is_mode_intact(std::uint64_t mode);
  /// Returns false and stops the interpreter if an LSI of a library overwrote foreign memory or changed the floating-point mode `mode`.
  [[nodiscard]] bool are_libraries_sound(std::uint64_t mode) {
    return is_mode_intact(mode) && (is_stopped || fences.empty() || are_fences_intact());
  }
  template <bool timed, bool probed>
  std::uint64_t run_fast(std::uint64_t count);
  std::uint64_t run(std::uint64_t count);
  bool tick_with_extras();
  bool run_one_by_one(std::span<const Job> jobs);
  bool run_wave(const Wave& wave);
  bool run_waves();
  void end_tick();
  void update_plain();
  void fail(const Job& job, bool not_finite);
  [[nodiscard]] int find_unit(std::string_view id) const;
  [[nodiscard]] PinView view(const Source& source) const;
  [[nodiscard]] const double* find_number(std::string_view pin, std::size_t component, Error& problems) const;
  void store_objects();
  void recall_objects();
  void sample_probes();
  void test_breakpoints();
  void record_inputs();
  void replay_inputs();
};

/// Lays out the arena, binds all addresses, calls `make` of the LSIs and sets the initial state.
/// @param problems  receives the problems that `make` of an LSI reports
[[nodiscard]] std::unique_ptr<Interpreter::Machine> make_machine(FlatCircuit flat, Plan plan, const BuildOptions& options, Error& problems);

/// Whether all numbers are finite, without a branch for each: x - x is 0 for finite x only.
inline bool all_finite(const double* x, std::uint32_t count) {
  if (count == 1) return *x - *x == 0;
  typedef double Two __attribute__((vector_size(16), aligned(8), may_alias));  // two numbers in SIMD lanes
  Two even = {}, odd = {};
  std::uint32_t i = 0;
  for (; i + 4 <= count; i += 4) {
    const Two a = *reinterpret_cast<const Two*>(x + i), b = *reinterpret_cast<const Two*>(x + i + 2);
    even += a - a;
    odd += b - b;
  }
  even += odd;
  double sum = even[0] + even[1];
  for (; i < count; ++i) sum += x[i] - x[i];
  return sum == 0;
}

}  // namespace ugoki::circuit
