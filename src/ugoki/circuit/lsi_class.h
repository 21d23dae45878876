#pragma once
// Declaration of a software LSI (component of a circuit): its pins, parameters, state and functions.
//
// An LSI has two functions; the interpreter calls both at every tick:
//   step     reads the `direct` inputs and writes the feed-through outputs (those not marked `delayed`);
//   advance  runs after all steps, reads all inputs, updates the state and writes the `delayed` outputs. Consumers see the new values of
//            all delayed outputs from the end of the tick on.
// During a tick a delayed output therefore has its value of the previous tick. This makes feedback possible.

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <ugoki/lsi.h>

#include "ugoki/circuit/pin_type.h"

namespace ugoki::circuit {

// The binary interface of LSIs is the C header ugoki/lsi.h: functions of plug-ins are called directly, like built-in ones.

/// Time and index of a tick.
using Tick = ugoki_tick;
/// Argument of step, advance and init: addresses of inputs, outputs, parameters and state, bound once when the circuit is built.
using Call = ugoki_call;
/// Returns 0 on success. Any other value stops the interpreter; Call::reason then contains the reason as text.
using StepFunction = ugoki_step_function;

/// Payload of input wire i as doubles; null for an unwired pin without a fixed size.
inline const double* input(const Call* call, std::size_t i) { return static_cast<const double*>(call->in[i]); }
/// Payload of output pin i as doubles.
inline double* output(const Call* call, std::size_t i) { return static_cast<double*>(call->out[i]); }
/// Writes `reason` into the buffer Call::reason, truncated to the size of the buffer, and returns 1. Use: `return stop(call, "...")`.
std::int32_t stop(const Call* call, std::string_view reason);

struct InputPin {
  std::string name;
  PinTypeId type = PinTypeId::scalar;
  std::string unit;
  std::string doc;
  bool required = true;     ///< a circuit without a wire or a fixed value for this pin is refused
  bool direct = true;       ///< read by `step`; false: read by `advance` only, and so never part of an algebraic loop
  bool multiple = false;    ///< true: accepts any number of wires, sorted by the ids of their sources; declared after all other inputs
  std::uint32_t count = 0;  ///< number of elements; 0: as for the pin type, or as at the wired output
  double value = 0;         ///< value of every number of an optional pin without a wire (rotations and poses: the identity instead)
  double minimum = 0;       ///< lower bound of fixed values; values out of bounds are refused; minimum == maximum: no bounds
  double maximum = 0;       ///< upper bound of fixed values
};

struct OutputPin {
  std::string name;
  PinTypeId type = PinTypeId::scalar;
  std::string unit;
  std::string doc;
  bool delayed = false;     ///< written by `advance`, seen by consumers from the next tick on
  std::uint32_t count = 0;  ///< number of elements; 0: as for the pin type, as at input `like`, or set by `configure`
  double minimum = 0;       ///< lower end of the usual values, for plots; minimum == maximum: unknown
  double maximum = 0;       ///< upper end of the usual values
  int like = -1;            ///< index of the input that has the same number of elements; -1: none
};

enum class ParameterKind : std::uint8_t { number, integer, boolean, text, choice, vector };

using Value = std::variant<double, bool, std::string, std::vector<double>>;

struct Parameter {
  std::string name;
  ParameterKind kind = ParameterKind::number;
  Value initial = 0.0;      ///< default value; a choice: one of `choices`
  double minimum = -1e300;  ///< lower bound of a number, an integer or each component of a vector; -1e300: no bound
  double maximum = 1e300;   ///< upper bound, as `minimum`; 1e300: no bound
  std::vector<std::string> choices;
  std::string unit;
  std::string doc;
  bool live = true;  ///< may be changed while the circuit runs; a text parameter never may, whatever this value is
};

enum class FieldType : std::uint8_t { f64 = 1, f32, i64, i32, u64, u32, i8, u8 };  // same values as ugoki_field_type
[[nodiscard]] std::size_t bytes_of(FieldType type);

/// A declared part of the state of an LSI. Editors show its value. The value is kept when a library is rebuilt with another layout of the
/// state.
struct StateField {
  std::string name;
  FieldType type = FieldType::f64;
  std::uint32_t offset = 0;  ///< offset from the beginning of the state, bytes
  std::uint32_t count = 1;   ///< number of elements
  std::string unit;
  std::string doc;
  double initial = 0;  ///< initial value of every element
  friend bool operator==(const StateField&, const StateField&) = default;
};

class Setup;

/// A kind of software LSI. Documentation, editor widgets, the save format and checks are derived from this declaration.
struct LsiClass {
  std::string name;           ///< "motion control", or "library/name" in an installed library; unique in a Library
  std::string doc;            ///< description in one or two sentences
  std::string group;          ///< heading in the editor's list of LSIs, for example "signal"
  std::string from;           ///< name of the installed library; empty: built in
  std::uint32_t version = 1;  ///< version of layout and meaning of the state; a state saved with another version is not restored
  std::vector<InputPin> inputs;
  std::vector<OutputPin> outputs;
  std::vector<Parameter> parameters;
  std::vector<StateField> fields;  ///< declared parts of the state; may be empty
  std::size_t state_bytes = 0;     ///< minimum size of the state; `configure` may set a larger one
  /// Name of the device ("keyboard"). If not empty, the host writes the outputs between ticks, and the outputs are recorded as inputs.
  std::string device;

  /// Sets the sizes of the state and of outputs without a fixed size, from parameters, resources and the sizes of inputs. May be called
  /// several times while sizes become known, and must not store anything between calls. Null: all pins have the sizes of their types.
  void (*configure)(Setup&) = nullptr;
  /// Creates Call::object, for data that is not plain bytes. Called once, when all sizes are known. To refuse the circuit, the
  /// function reports a problem and returns null.
  void* (*make)(Setup&) = nullptr;
  void (*destroy)(void* object) = nullptr;
  const ugoki_class* abi = nullptr;  ///< the declaration of the class by its plug-in, which `make` reads
  /// Sets the initial values of the state and of delayed outputs, which are zero before the call. Called at build and at reset.
  StepFunction init = nullptr;
  StepFunction step = nullptr;
  StepFunction advance = nullptr;
  /// For an object (see `make`) with its own state: `store` copies this state into Call::state before a save, `recall` copies it back after
  /// a restore.
  void (*store)(const Call*) = nullptr;
  void (*recall)(const Call*) = nullptr;

  [[nodiscard]] int find_input(std::string_view pin) const;  ///< index of the input with this name, or -1
  [[nodiscard]] int find_output(std::string_view pin) const;
  [[nodiscard]] int find_parameter(std::string_view parameter) const;
  /// Hash of version, size and declared fields of the state. Classes with equal hashes can exchange the bytes of their states.
  [[nodiscard]] std::uint64_t state_layout() const;
};

}  // namespace ugoki::circuit
