#pragma once
// Runs a circuit, tick by tick. Everything is decided when it is built; a tick calls functions through bound addresses in a fixed
// order, allocates nothing and locks nothing, and gives the same bits every time.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/circuit/circuit.h"
#include "ugoki/circuit/input_record.h"
#include "ugoki/circuit/library.h"
#include "ugoki/circuit/resources.h"

namespace ugoki::circuit {

struct Activity;
class Executor;

struct BuildOptions {
  double dt = 0.002;             ///< s, between ticks
  bool check_finite = true;      ///< after each LSI, stop if a number it gave is not finite
  Activity* activity = nullptr;  ///< where to note which LSI runs (activity.h); outlives the interpreter
};

/// Why an interpreter stopped. The values of delayed outputs (the state) are still those of the last good tick.
struct Stop {
  std::string lsi;
  std::string pin;      ///< "id.pin" of the output that was not finite; empty otherwise
  std::string library;  ///< that the LSI was installed with; empty: the program's own
  std::string reason;
  std::string inputs;  ///< " Its inputs were ..." for those of few numbers
  std::uint64_t tick = 0;
  double time = 0;  ///< s
  [[nodiscard]] std::string text() const;
};

/// A payload seen from outside, valid until the interpreter ends; read it between ticks.
struct PinView {
  PinTypeId type = PinTypeId::scalar;
  std::uint32_t count = 0;  ///< elements
  std::span<const std::byte> bytes;

  /// The payload's numbers (numeric types).
  [[nodiscard]] std::span<const double> numbers() const {
    return {reinterpret_cast<const double*>(bytes.data()), bytes.size() / sizeof(double)};
  }
};

/// Time that one LSI took so far, in the clock's units.
struct Timing {
  std::string lsi;
  std::uint64_t runs = 0;  ///< calls of step and advance that were timed
  std::uint64_t total = 0;
};

enum class Comparison : std::uint8_t { above, below, equal, not_equal, changed };

/// A condition on a number of a pin. It is met at the tick at which it becomes true.
struct Breakpoint {
  std::string pin;  ///< "id.pin"
  std::size_t component = 0;
  Comparison comparison = Comparison::above;
  double value = 0;  ///< unused by `changed`
};

/// What probes have caught: rows of the same numbers, oldest first.
class ProbeRows {
 public:
  [[nodiscard]] std::size_t size() const { return rows_; }
  [[nodiscard]] std::uint64_t first() const { return first_; }  ///< rows that were caught and overwritten before row 0
  [[nodiscard]] std::uint64_t tick(std::size_t row) const { return ticks_[at(row)]; }
  /// The numbers of all pins, in the order in which they were given to set_probes.
  [[nodiscard]] std::span<const double> numbers(std::size_t row) const { return {data_ + at(row) * width_, width_}; }

 private:
  friend class Interpreter;
  [[nodiscard]] std::size_t at(std::size_t row) const { return static_cast<std::size_t>((first_ + row) % capacity_); }
  const double* data_ = nullptr;
  const std::uint64_t* ticks_ = nullptr;
  std::size_t rows_ = 0, width_ = 0, capacity_ = 1;
  std::uint64_t first_ = 0;
};

/// An output that the host writes between ticks: a key, an axis, a packet.
struct DeviceSlot {
  std::string id;       ///< of the LSI
  std::string device;   ///< LsiClass::device: "keyboard"
  std::string address;  ///< its first text or choice: which key
  std::string pin;
  std::span<double> numbers;
};

class Interpreter {
 public:
  /// Counts in any unit; nothing in the runtime depends on it.
  using Clock = std::uint64_t (*)();
  /// The processor's counter of time, the cheapest clock there is (0 where there is none).
  static std::uint64_t processor_clock();
  /// The form that runs; seen by the runtime only.
  struct Machine;

  /// Opens, checks, sizes and schedules the circuit, and sets the first state. All problems are reported, with the names of LSIs
  /// and pins. @param library, resources outlive the interpreter
  [[nodiscard]] static Result<Interpreter> build(const Circuit& circuit, const Library& library, const Resources* resources,
                                                 const BuildOptions& options);

  Interpreter(Interpreter&&) noexcept;
  Interpreter& operator=(Interpreter&&) noexcept;
  ~Interpreter();

  /// Computes one tick. False: an LSI stopped it (see stopped()); a stopped interpreter stays so until reset or restore.
  bool tick();
  /// Computes up to `count` ticks: cheaper than as many calls of tick(). Ends after a tick that met a breakpoint, and where an LSI stopped
  /// it.
  /// @return ticks done
  std::uint64_t run(std::uint64_t count);
  /// Runs one LSI of the tick that is under way, or the first of the next; the last one ends the tick. tick() completes what is begun.
  bool step_lsi();
  /// Id of the LSI that step_lsi would run; empty where the circuit has none.
  [[nodiscard]] std::string next_lsi() const;
  /// Runs the LSIs that run on demand only (displays), on the values of the last tick. False: one of them stopped.
  bool refresh();
  /// Back to the first state.
  void reset();

  [[nodiscard]] std::uint64_t ticks() const;  ///< done so far
  [[nodiscard]] double time() const;          ///< s, ticks() * dt
  [[nodiscard]] const Stop* stopped() const;  ///< null while all is well

  /// The output "id.pin" (ids of nested circuits with '/'), or an error that names it.
  [[nodiscard]] Result<PinView> find_output(std::string_view pin) const;
  /// An output of the circuit itself, by name.
  [[nodiscard]] Result<PinView> find_circuit_output(std::string_view name) const;
  /// Payload of an input of the circuit itself, to be written between ticks; empty if there is none of this name. Keeps its value.
  [[nodiscard]] std::span<std::byte> find_circuit_input(std::string_view name);

  /// All outputs that devices feed. They keep their values until they are written again.
  [[nodiscard]] std::vector<DeviceSlot> devices();

  /// Changes a live parameter between ticks: `pin` is "id.parameter", `component` counts in vectors.
  Result<void> set_parameter(std::string_view parameter, double value, std::size_t component = 0);

  /// All state as bytes. The same circuit, library and dt can take it back.
  void save(std::vector<std::byte>& bytes);
  /// Refuses bytes of another circuit and damaged ones, and is then unchanged.
  Result<void> restore(std::span<const std::byte> bytes);
  /// Takes over the state of every LSI that is the same in `other` (id, class, version, sizes): for rebuilding a circuit while
  /// it runs. Where only the layout of the state differs, declared fields of the same name, type and count are taken.
  /// @return number of LSIs whose state was taken whole
  std::size_t adopt(Interpreter& other) { return adopt_report(other).kept; }
  struct Adoption {
    std::size_t kept = 0;
    std::vector<std::string> partly, afresh;  ///< sentences: "'id': the field 'y' is new."
  };
  Adoption adopt_report(Interpreter& other);

  /// Starts counting at zero. Null: off.
  /// @param one_in how many ticks go to one whose LSIs are timed. 1: each tick. A look at the clock costs more than a small LSI; of
  ///   one tick in four (spread so that LSIs that run at every n-th tick are met as often as all others) the means are the same.
  void set_timing(Clock clock, std::uint32_t one_in = 1);
  /// Ticks whose LSIs were timed since then.
  [[nodiscard]] std::uint64_t timed_ticks() const;
  [[nodiscard]] std::vector<Timing> timings() const;

  /// Catches these numeric pins ("id.pin") at each `every`-th tick, as consumers see them, into a ring of `rows`. Replaces what was probed.
  Result<void> set_probes(std::span<const std::string> pins, std::size_t rows, std::uint32_t every = 1);
  [[nodiscard]] ProbeRows probes() const;

  /// Replaces all breakpoints. A tick at which one is met is completed; breakpoint_hit() then tells which.
  Result<void> set_breakpoints(std::span<const Breakpoint> breakpoints);
  /// Index of the breakpoint that the last tick met, or -1.
  [[nodiscard]] int breakpoint_hit() const;

  /// Records what comes from outside (inputs of the circuit, devices, parameters), from now on.
  void start_recording();
  /// What was recorded, with the time between ticks and a hash of the circuit.
  [[nodiscard]] InputRecord recording() const;
  /// From now on every change comes at its tick. Refuses a record of another circuit.
  Result<void> replay(const InputRecord& record);

  /// Runs independent LSIs on several threads, with the same bits; null: on this one. It outlives the interpreter.
  void set_executor(Executor* executor);

  /// Ids in the order in which steps run.
  [[nodiscard]] std::vector<std::string> schedule() const;
  /// Bytes of the arena in which all payloads and states lie.
  [[nodiscard]] std::size_t arena_bytes() const;

 private:
  explicit Interpreter(std::unique_ptr<Machine> machine);
  std::unique_ptr<Machine> machine_;
};

}  // namespace ugoki::circuit
