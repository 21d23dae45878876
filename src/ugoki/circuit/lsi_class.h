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

#include <ugoki/lsi.h>

#include "ugoki/circuit/pin_type.h"

namespace ugoki::circuit {

/// The binary interface of LSIs is a C header, so that functions compiled elsewhere are called as ours are: without anything between.
using Tick = ugoki_tick;
/// What step, advance and init are given: addresses bound once when the circuit is built.
using Call = ugoki_call;
/// 0: done. Anything else stops the interpreter; Call::reason says why.
using StepFunction = ugoki_step_function;

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
  double minimum = 0;       ///< what the LSI is meant for; refused outside as a given value. Equal to maximum: any number
  double maximum = 0;
};

struct OutputPin {
  std::string name;
  PinTypeId type = PinTypeId::scalar;
  std::string unit;
  std::string doc;
  bool delayed = false;     ///< written by `advance`, seen from the next tick on
  std::uint32_t count = 0;  ///< elements; 0: those of the type, or as `like` says, or set by `configure`
  double minimum = 0;       ///< what it usually lies between, for plots. Equal to maximum: unknown
  double maximum = 0;
  int like = -1;  ///< as many elements as this input has
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

enum class FieldType : std::uint8_t { f64 = 1, f32, i64, i32, u64, u32, i8, u8 };  // as ugoki_field_type
[[nodiscard]] std::size_t bytes_of(FieldType type);

/// A declared part of the state: shown, and kept by name when a library is rebuilt with another layout.
struct StateField {
  std::string name;
  FieldType type = FieldType::f64;
  std::uint32_t offset = 0;  ///< bytes into the state
  std::uint32_t count = 1;   ///< elements
  std::string unit;
  std::string doc;
  double initial = 0;  ///< every element at the start
  friend bool operator==(const StateField&, const StateField&) = default;
};

class Setup;

/// A kind of software LSI. Declared once: pins, documentation, widgets, save format and checks follow from it.
struct LsiClass {
  std::string name;           ///< "motion control"; unique in a library
  std::string doc;            ///< a sentence or two
  std::string group;          ///< where a search lists it: "signal"
  std::string from;           ///< library that it was installed with; empty: built in
  std::uint32_t version = 1;  ///< of its state layout; saved states of another version are not restored
  std::vector<InputPin> inputs;
  std::vector<OutputPin> outputs;
  std::vector<Parameter> parameters;
  std::vector<StateField> fields;  ///< declared parts of the state; may be none
  std::size_t state_bytes = 0;     ///< of the state, where `configure` does not ask for more
  /// Not empty: its outputs are written by the host between ticks (a key, a packet), and recorded with the inputs of the circuit.
  std::string device;

  /// Sets sizes of sized outputs and of the state from parameters, resources and the sizes of inputs; may be called several
  /// times as sizes become known; keeps nothing. Null: all pins have the sizes of their types, no state.
  void (*configure)(Setup&) = nullptr;
  /// Called once, when all sizes are known: makes what does not fit into plain bytes. Null result with a problem: refused.
  void* (*make)(Setup&) = nullptr;
  void (*destroy)(void* object) = nullptr;
  const ugoki_class* abi = nullptr;  ///< the declaration of a plug-in, for its `make`
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
  /// Hash of version, size and declared fields of the state: equal hashes mean that the bytes of one fit the other.
  [[nodiscard]] std::uint64_t state_layout() const;
};

}  // namespace ugoki::circuit
