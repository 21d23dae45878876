#pragma once
// The form that runs: one arena, calls with bound addresses, lists of jobs. Private to the interpreter.

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "ugoki/circuit/activity.h"
#include "ugoki/circuit/arena.h"
#include "ugoki/circuit/interpreter.h"
#include "ugoki/circuit/plan.h"

namespace ugoki::circuit {

/// One call of a schedule.
struct Job {
  StepFunction run = nullptr;
  Call* call = nullptr;
  const RunningLsi* who = nullptr;
  const double* check = nullptr;  ///< numbers it writes, to be finite
  std::uint32_t check_count = 0;
  std::uint32_t every = 1;
  std::uint32_t lsi = 0;
};

/// Jobs [begin, end) that do not depend on each other; those of plug-ins from own_end on.
struct Wave {
  std::uint32_t begin = 0, own_end = 0, end = 0;
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
  std::string address;                    ///< of a device: its first text or choice
};

/// A word in front of and behind what an LSI of a library writes, which nobody may change: so one that writes beyond its own is found.
struct Fence {
  static constexpr std::uint64_t intact = 0x5AFE5AFE5AFE5AFE;  // finite as a number: it may lie between some that are checked to be
  enum class Side : std::uint8_t { before_outputs, after_output, before_state, after_state };
  std::size_t at = 0;  ///< bytes in the arena
  std::uint32_t lsi = 0, pin = 0;
  Side side = Side::after_output;
};

struct ProbeBuffer {
  std::vector<const double*> sources;  ///< [width] numbers that are copied at the end of a tick
  std::vector<double> rows;            ///< [capacity][width]
  std::vector<std::uint64_t> ticks;
  std::uint64_t written = 0;  ///< rows so far
  std::size_t next = 0;       ///< row to write
  std::uint32_t every = 1;

  [[nodiscard]] std::size_t width() const { return sources.size(); }
};

struct ActiveBreakpoint {
  Breakpoint what;
  const double* number = nullptr;
  double last = 0;
  bool armed = false;  ///< the condition was false at the tick before, or `last` is known
};

/// What may come from outside: an input of the circuit, an output of a device, a parameter.
struct RecordedSlot {
  std::string name;
  std::span<std::byte> now;
  std::vector<std::byte> before;
};

struct InputLog {
  std::vector<RecordedSlot> slots;
  std::vector<InputChange> changes;
  bool recording = false;
  std::vector<InputChange> replay;  ///< by tick
  std::size_t next = 0;
};

struct Interpreter::Machine {
  ~Machine();

  std::vector<Unit> units;             ///< [lsis], sorted by id
  std::vector<RunningLsi> running;     ///< [lsis]
  std::vector<Call> calls;             ///< [lsis] in the order of the schedule
  std::vector<std::uint32_t> call_of;  ///< [lsis] index into calls
  std::vector<const void*> in;         ///< of all calls
  std::vector<void*> out;
  std::vector<std::uint32_t> in_first, in_count, out_count;
  std::vector<double> parameters;
  Arena arena;
  std::vector<Fence> fences;
  Range front, back;           ///< delayed outputs: as seen, as written; same order
  std::vector<Job> jobs;       ///< of a tick: all steps, then all advances
  std::size_t step_count = 0;  ///< how many of them are steps
  std::vector<Job> on_demand;
  std::vector<std::uint32_t> wave_ends;  ///< ends in `jobs` of the steps of equal depth
  std::vector<int> order;
  std::vector<FlatPort> inputs, outputs;
  std::uint64_t layout = 0;  ///< hash of ids, classes, versions and sizes
  Tick tick{};
  Activity* activity = nullptr;
  Activity own_activity;

  // What costs nothing while it is off.
  bool plain = true;  ///< none of the following
  bool fast = true;   ///< nothing but a clock and probes at each tick
  Clock clock = nullptr;
  std::uint32_t timed_one_in = 1;
  std::uint64_t timed_ticks = 0;
  std::vector<Timing> timings;  ///< [lsis], id empty
  Executor* executor = nullptr;
  std::vector<std::vector<char>> reasons;  ///< [workers]
  std::vector<Job> wave_jobs;              ///< `jobs`, sorted for threads
  std::vector<Wave> waves;
  ProbeBuffer probes;
  std::vector<ActiveBreakpoint> breakpoints;
  int breakpoint_hit = -1;
  InputLog log;
  std::uint32_t cursor = 0;  ///< jobs of this tick that are done (single step)

  bool is_stopped = false;
  Stop stop;
  char reason[512] = {};

  [[nodiscard]] std::byte* bytes() { return reinterpret_cast<std::byte*>(arena.data()); }
  [[nodiscard]] const std::byte* bytes() const { return reinterpret_cast<const std::byte*>(arena.data()); }
  [[nodiscard]] Call& call_at(std::size_t lsi) { return calls[call_of[lsi]]; }
  void initialise();
  void set_fences();
  [[nodiscard]] bool are_fences_intact();
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

/// Lays out the arena and binds all addresses. @param problems gets what `make` of an LSI refuses
[[nodiscard]] std::unique_ptr<Interpreter::Machine> make_machine(FlatCircuit flat, Plan plan, const BuildOptions& options, Error& problems);

/// All finite, without a branch for each: x - x is 0 for a finite x only.
inline bool all_finite(const double* x, std::uint32_t count) {
  if (count == 1) return *x - *x == 0;
  double even = 0, odd = 0;
  std::uint32_t i = 0;
  for (; i + 1 < count; i += 2) {
    even += x[i] - x[i];
    odd += x[i + 1] - x[i + 1];
  }
  if (i < count) even += x[i] - x[i];
  return even + odd == 0;
}

}  // namespace ugoki::circuit
