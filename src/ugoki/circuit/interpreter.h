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
#include "ugoki/circuit/library.h"
#include "ugoki/circuit/resources.h"

namespace ugoki::circuit {

struct BuildOptions {
  double dt = 0.002;         ///< s, between ticks
  bool check_finite = true;  ///< after each LSI, stop if a number it gave is not finite
};

/// Why an interpreter stopped. The values of delayed outputs (the state) are still those of the last good tick.
struct Stop {
  std::string lsi;
  std::string reason;
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
  std::uint64_t runs = 0;  ///< calls of step and advance
  std::uint64_t total = 0;
};

class Interpreter {
 public:
  /// Counts in any unit; nothing in the runtime depends on it.
  using Clock = std::uint64_t (*)();
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

  /// Changes a live parameter between ticks: `pin` is "id.parameter", `component` counts in vectors.
  Result<void> set_parameter(std::string_view parameter, double value, std::size_t component = 0);

  /// All state as bytes. The same circuit, library and dt can take it back.
  void save(std::vector<std::byte>& bytes);
  /// Refuses bytes of another circuit and damaged ones, and is then unchanged.
  Result<void> restore(std::span<const std::byte> bytes);
  /// Takes over the state of every LSI that is the same in `other` (id, class, version, sizes): for rebuilding a circuit while
  /// it runs. @return number of LSIs whose state was taken
  std::size_t adopt(Interpreter& other);

  /// Null: off. Starts counting at zero.
  void set_timing(Clock clock);
  [[nodiscard]] std::vector<Timing> timings() const;

  /// Ids in the order in which steps run.
  [[nodiscard]] std::vector<std::string> schedule() const;
  /// Bytes of the arena in which all payloads and states lie.
  [[nodiscard]] std::size_t arena_bytes() const;

 private:
  explicit Interpreter(std::unique_ptr<Machine> machine);
  std::unique_ptr<Machine> machine_;
};

}  // namespace ugoki::circuit
