#pragma once
// Runs a circuit of LSIs (components), tick by tick. Building the circuit fixes the addresses and sizes of all values and the order of the
// LSIs. A tick calls the functions of the LSIs in this order, without allocating or locking; repeated runs give the same bits.

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
  double dt = 0.002;             ///< time between two ticks, s
  bool check_finite = true;      ///< stop if an LSI writes a number that is not finite; checked after each LSI
  Activity* activity = nullptr;  ///< receives the LSI that is running (activity.h); must outlive the interpreter
};

/// Why an interpreter stopped. Delayed outputs keep the values of the last complete tick.
struct Stop {
  std::string lsi;      ///< id of the LSI that stopped the interpreter
  std::string pin;      ///< "id.pin" of the output at fault (not finite, or written past its end); empty: none
  std::string library;  ///< name of the LSI's installed library; empty: the LSI is built in
  std::string reason;
  std::string inputs;  ///< " Its inputs were ...", as written by describe_inputs (activity.h)
  std::uint64_t tick = 0;
  double time = 0;  ///< simulated time of the tick, s
  /// Message for the user: "'id' of library 'x' stopped at 0.123 s (tick 61): REASON INPUTS"
  [[nodiscard]] std::string text() const;
};

/// View of the payload of an output. Valid for the lifetime of the interpreter; read it between ticks only.
struct PinView {
  PinTypeId type = PinTypeId::scalar;
  std::uint32_t count = 0;  ///< number of elements of the payload
  std::span<const std::byte> bytes;

  /// The payload as numbers; only for numeric pin types.
  [[nodiscard]] std::span<const double> numbers() const {
    return {reinterpret_cast<const double*>(bytes.data()), bytes.size() / sizeof(double)};
  }
};

/// Computing time of one LSI.
struct Timing {
  std::string lsi;          ///< id of the LSI
  std::uint64_t runs = 0;   ///< number of timed calls of the LSI's step and advance functions
  std::uint64_t total = 0;  ///< time of these calls, in the unit of the clock
};

enum class Comparison : std::uint8_t { above, below, equal, not_equal, changed };

/// A condition on one number of a pin. The breakpoint is met at the tick at which the condition becomes true.
struct Breakpoint {
  std::string pin;            ///< pin whose value is compared, "id.pin"
  std::size_t component = 0;  ///< index of the number in the payload
  Comparison comparison = Comparison::above;
  double value = 0;  ///< value with which the number is compared; unused by `changed`
};

/// View of the samples of the probes (sampled pins): one row per sampled tick, oldest first. Valid until the next tick or set_probes().
class ProbeRows {
 public:
  [[nodiscard]] std::size_t size() const { return rows_; }
  [[nodiscard]] std::uint64_t first() const { return first_; }  ///< number of older rows, which have been overwritten
  [[nodiscard]] std::uint64_t tick(std::size_t row) const { return ticks_[at(row)]; }
  /// The numbers of all probed pins, in the order of the pins given to set_probes.
  [[nodiscard]] std::span<const double> numbers(std::size_t row) const { return {data_ + at(row) * width_, width_}; }

 private:
  friend class Interpreter;
  [[nodiscard]] std::size_t at(std::size_t row) const { return static_cast<std::size_t>((first_ + row) % capacity_); }
  const double* data_ = nullptr;
  const std::uint64_t* ticks_ = nullptr;
  std::size_t rows_ = 0, width_ = 0, capacity_ = 1;
  std::uint64_t first_ = 0;
};

/// An output that the host writes between ticks, for example the state of a key or an axis, or the value of a network message.
struct DeviceSlot {
  std::string id;       ///< id of the LSI
  std::string device;   ///< kind of the device, LsiClass::device: "keyboard"
  std::string address;  ///< value of the LSI's first text or choice parameter, for example the name of the key
  std::string pin;
  std::span<double> numbers;
};

class Interpreter {
 public:
  /// Returns a time in any unit; the unit has no effect on the run.
  using Clock = std::uint64_t (*)();
  /// Reads the processor's time counter (x86-64: TSC, AArch64: CNTVCT), the cheapest clock available. Returns 0 on other processors.
  static std::uint64_t processor_clock();
  /// The executable form of the circuit (machine.h). Private to this module.
  struct Machine;

  /// Flattens, checks and schedules the circuit, sizes its payloads, and sets the initial state. All problems are reported, each with the
  /// names of the LSIs and pins concerned.
  /// @param library, resources  must outlive the interpreter
  [[nodiscard]] static Result<Interpreter> build(const Circuit& circuit, const Library& library, const Resources* resources,
                                                 const BuildOptions& options);

  Interpreter(Interpreter&&) noexcept;
  Interpreter& operator=(Interpreter&&) noexcept;
  ~Interpreter();

  /// Computes one tick. Returns false if an LSI stopped the interpreter (see stopped()). The interpreter remains stopped until reset() or
  /// restore().
  bool tick();
  /// Computes up to `count` ticks, at less cost than `count` calls of tick(). Ends early after a tick in which a breakpoint's condition was
  /// met, or if an LSI stopped the interpreter.
  /// @return number of completed ticks
  std::uint64_t run(std::uint64_t count);
  /// Runs the next LSI of the current tick. The call that runs the last LSI also ends the tick. If tick() is called before that, it
  /// runs the remaining LSIs and ends the tick.
  /// Returns false if an LSI stopped the interpreter.
  bool step_lsi();
  /// Id of the LSI that step_lsi would run; empty if none is due.
  [[nodiscard]] std::string next_lsi() const;
  /// Runs the LSIs that run on demand only (displays), with the values of the last tick. Returns false if an LSI stopped
  /// the interpreter.
  bool refresh();
  /// Restores the initial state.
  void reset();

  [[nodiscard]] std::uint64_t ticks() const;  ///< number of ticks computed so far
  [[nodiscard]] double time() const;          ///< simulated time, s: ticks() * dt
  [[nodiscard]] const Stop* stopped() const;  ///< why the interpreter has stopped; null: not stopped

  /// Finds the output "id.pin" (in a nested circuit: "arm/elbow.pin"), or returns an error whose location is `pin`.
  [[nodiscard]] Result<PinView> find_output(std::string_view pin) const;
  /// Finds an output of the circuit itself by its name.
  [[nodiscard]] Result<PinView> find_circuit_output(std::string_view name) const;
  /// Writable payload (bytes of the value) of an input of the circuit itself; empty if no input has this name. Write the payload between
  /// ticks only; the input keeps the value until the next write.
  [[nodiscard]] std::span<std::byte> find_circuit_input(std::string_view name);

  /// All outputs of device LSIs. The host writes them between ticks; each value is kept until it is written again.
  [[nodiscard]] std::vector<DeviceSlot> devices();

  /// Changes a live parameter between ticks.
  /// @param parameter  "id.parameter"
  /// @param component  index in a vector parameter; otherwise 0
  Result<void> set_parameter(std::string_view parameter, double value, std::size_t component = 0);

  /// Writes the complete state to `bytes`. An interpreter of the same circuit, library and dt can restore it.
  void save(std::vector<std::byte>& bytes);
  /// Restores a state written by save. If the bytes are damaged or belong to another circuit, returns an error and changes nothing.
  Result<void> restore(std::span<const std::byte> bytes);
  /// Copies the states from the interpreter `other`, so that a circuit can be rebuilt while it runs. The complete state of an LSI is copied
  /// if both interpreters have it with the same id, class, version and sizes. If only the layout of the state differs, declared fields of
  /// the same name, type and count are copied.
  /// @return number of LSIs whose state was copied completely
  std::size_t adopt(Interpreter& other) { return adopt_report(other).kept; }
  struct Adoption {
    std::size_t kept = 0;             ///< number of LSIs whose state was copied completely
    std::vector<std::string> partly;  ///< one sentence per LSI: "'id' keeps 1 fields of its state; the field 'y' is new."
    std::vector<std::string> afresh;  ///< one sentence per LSI that starts from its initial state, with the reason
  };
  Adoption adopt_report(Interpreter& other);

  /// Resets all times to zero and starts timing the LSIs with `clock`. A null clock stops timing.
  /// @param one_in  one tick in `one_in` is timed, because reading the clock costs more than a small LSI. The timed ticks are spread
  ///   pseudo-randomly, so that LSIs that run at every n-th tick are sampled as often as all others, and mean times stay unbiased.
  void set_timing(Clock clock, std::uint32_t one_in = 1);
  /// Number of ticks timed since set_timing.
  [[nodiscard]] std::uint64_t timed_ticks() const;
  [[nodiscard]] std::vector<Timing> timings() const;

  /// Samples these numeric pins ("id.pin") at each `every`-th tick into a ring buffer of `rows` rows. A sample is the value that consumers
  /// read in the tick. Replaces all earlier probes.
  Result<void> set_probes(std::span<const std::string> pins, std::size_t rows, std::uint32_t every = 1);
  [[nodiscard]] ProbeRows probes() const;

  /// Replaces all breakpoints. A tick that meets a breakpoint is completed; breakpoint_hit() then returns the breakpoint's index.
  Result<void> set_breakpoints(std::span<const Breakpoint> breakpoints);
  /// Index of the breakpoint that the last tick met, or -1.
  [[nodiscard]] int breakpoint_hit() const;

  /// Starts recording every change of an input of the circuit, an output of a device LSI or a live parameter.
  void start_recording();
  /// The changes recorded so far, with dt and a hash of the circuit.
  [[nodiscard]] InputRecord recording() const;
  /// From now on, applies each change of the record before the tick at which it was recorded.
  /// Returns an error for a record of another circuit.
  Result<void> replay(const InputRecord& record);

  /// Runs independent LSIs on the threads of `executor`; null: on the calling thread. The results have the same bits. `executor` must
  /// outlive the interpreter.
  void set_executor(Executor* executor);

  /// Ids of the LSIs in the order in which their steps run.
  [[nodiscard]] std::vector<std::string> schedule() const;
  /// Size in bytes of the memory that contains all payloads and states.
  [[nodiscard]] std::size_t arena_bytes() const;

 private:
  explicit Interpreter(std::unique_ptr<Machine> machine);
  std::unique_ptr<Machine> machine_;
};

}  // namespace ugoki::circuit
