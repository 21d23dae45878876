#pragma once
// What the author of a software LSI declares, and what its functions are given.
//
// An LSI has two functions that run at every tick of the interpreter:
//   step     reads the `direct` inputs and writes the feed-through outputs (those not marked `delayed`);
//   advance  reads all inputs (final by then), moves the state on and writes the `delayed` outputs, which all consumers see
//            change together at the end of the tick.
// So the value of a delayed output during a tick is that of the tick before, and feedback is possible through it.

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "ugoki/circuit/pin_type.h"

namespace ugoki::circuit {

/// The moment for which a tick computes. Plain data.
struct Tick {
  double time = 0;          ///< s, index * dt
  double dt = 0;            ///< s
  std::uint64_t index = 0;  ///< ticks done before this one
};

/// What step, advance and init are given: addresses bound once when the circuit is built. Plain data, so that a function
/// compiled elsewhere can be called through it.
struct Call {
  const void* const* in;           ///< payload of every wire into this LSI; pin i is in[in_first[i]] (in[i] as long as no earlier pin is
                                   ///< `multiple`); pins without wire have their default, sized pins without wire are null
  void* const* out;                ///< [outputs] payloads to write; delayed ones show themselves at the end of the tick
  const std::uint32_t* in_first;   ///< [inputs + 1]
  const std::uint32_t* in_count;   ///< elements of each payload of `in`
  const std::uint32_t* out_count;  ///< elements of each payload of `out`
  const double* parameters;        ///< numbers, booleans (0, 1), choices (index) and vectors (3) in the order of declaration
  void* state;                     ///< as many bytes as `configure` asked for, saved and restored by the interpreter
  void* object;                    ///< what `make` returned
  const Tick* tick;
  char* reason;               ///< where a function that returns non-zero says why (zero-terminated)
  std::uint32_t reason_size;  ///< bytes
};

/// 0: done. Anything else stops the interpreter; Call::reason says why.
using StepFunction = std::int32_t (*)(const Call*);

/// Payload of input wire i as doubles (null where nothing is wired to a sized pin).
inline const double* input(const Call* call, std::size_t i) { return static_cast<const double*>(call->in[i]); }
inline double* output(const Call* call, std::size_t i) { return static_cast<double*>(call->out[i]); }
/// Writes the reason and returns 1: `return stop(call, "...")`.
std::int32_t stop(const Call* call, std::string_view reason);

struct InputPin {
  std::string name;
  PinTypeId type = PinTypeId::scalar;
  std::string unit;
  std::string doc;
  bool required = true;     ///< refuses to run without a wire or a value
  bool direct = true;       ///< read by `step`; false: read by `advance` only, so that no value goes round through it in one tick
  bool multiple = false;    ///< takes any number of wires, ordered by the ids of their sources; after all other inputs
  std::uint32_t count = 0;  ///< elements; 0: those of the type, or of what is wired to it
  double value = 0;         ///< every number of an optional numeric pin that has no wire (rotations, poses: the identity)
};

struct OutputPin {
  std::string name;
  PinTypeId type = PinTypeId::scalar;
  std::string unit;
  std::string doc;
  bool delayed = false;     ///< written by `advance`, seen from the next tick on
  std::uint32_t count = 0;  ///< elements; 0: those of the type, or set by `configure`
};

enum class ParameterKind : std::uint8_t { number, integer, boolean, text, choice, vector };

using Value = std::variant<double, bool, std::string, std::vector<double>>;

struct Parameter {
  std::string name;
  ParameterKind kind = ParameterKind::number;
  Value initial = 0.0;      ///< choice: the word
  double minimum = -1e300;  ///< number, integer, vector components
  double maximum = 1e300;
  std::vector<std::string> choices;
  std::string unit;
  std::string doc;
  bool live = true;  ///< may be changed while it runs (never text)
};

class Setup;

/// A kind of software LSI. Declared once: pins, documentation, widgets, save format and checks follow from it.
struct LsiClass {
  std::string name;           ///< "motion control"; unique in a library
  std::string doc;            ///< a sentence or two
  std::uint32_t version = 1;  ///< of its state layout; saved states of another version are not restored
  std::vector<InputPin> inputs;
  std::vector<OutputPin> outputs;
  std::vector<Parameter> parameters;

  /// Sets sizes of sized outputs and of the state from parameters, resources and the sizes of inputs; may be called several
  /// times as sizes become known; keeps nothing. Null: all pins have the sizes of their types, no state.
  void (*configure)(Setup&) = nullptr;
  /// Called once, when all sizes are known: makes what does not fit into plain bytes. Null result with a problem: refused.
  void* (*make)(Setup&) = nullptr;
  void (*destroy)(void* object) = nullptr;
  /// Sets the first state and the first values of delayed outputs (zeroed before). Called at build and at reset.
  StepFunction init = nullptr;
  StepFunction step = nullptr;
  StepFunction advance = nullptr;
  /// For an `object` that remembers: moves what it remembers to and from `state`, before a save and after a restore.
  void (*store)(const Call*) = nullptr;
  void (*recall)(const Call*) = nullptr;

  [[nodiscard]] int find_input(std::string_view pin) const;  ///< index or -1
  [[nodiscard]] int find_output(std::string_view pin) const;
  [[nodiscard]] int find_parameter(std::string_view parameter) const;
};

}  // namespace ugoki::circuit
