#pragma once
// A circuit of software LSIs (components) as data: the form that users edit and save. Only Interpreter::build checks it against a library.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/circuit/lsi_class.h"

namespace ugoki::circuit {

inline constexpr int circuit_version = 2;

/// Position or size in the plane of the editor, px.
struct Position {
  double x = 0, y = 0;
  friend bool operator==(const Position&, const Position&) = default;
};

using NamedValue = std::pair<std::string, Value>;

/// One LSI (or circuit used as an LSI) in a circuit.
struct Instance {
  std::string id;                      ///< stable, unique in its circuit; 1 to 64 letters, digits, `_` and `-`
  std::string type;                    ///< name of a circuit in `circuits`, or of an LSI class
  std::string label;                   ///< title shown in the editor; may be empty
  std::string note;                    ///< comment of the user; may be empty
  Position at;                         ///< position of the LSI's box in the editor
  std::uint32_t every = 1;             ///< runs at each `every`-th tick; 0: runs only in Interpreter::refresh
  std::vector<NamedValue> parameters;  ///< values of parameters, by parameter name
  std::vector<NamedValue> values;      ///< fixed values of inputs without a wire, by pin name
  friend bool operator==(const Instance&, const Instance&) = default;
};

/// A connection from an output to an input, both written "id.pin".
struct Wire {
  std::string from, to;
  friend bool operator==(const Wire&, const Wire&) = default;
};

/// An input or output pin of the circuit itself.
struct BoundaryPin {
  std::string name;
  PinTypeId type = PinTypeId::scalar;
  std::string unit;
  std::string doc;
  /// Input: the inner inputs "id.pin" that receive the pin's value. Output: the single inner output "id.pin" whose value the pin passes
  /// on. Empty for an output: the circuit is unfinished, and building it reports an error.
  std::vector<std::string> ends;
  friend bool operator==(const BoundaryPin&, const BoundaryPin&) = default;
};

/// A parameter of the circuit itself. All inner parameters in `ends` receive its value.
struct BoundaryParameter {
  std::string name;
  std::string doc;
  std::vector<std::string> ends;  ///< parameters inside the circuit that receive the value, "id.parameter"
  friend bool operator==(const BoundaryParameter&, const BoundaryParameter&) = default;
};

/// A text note of the user in the circuit's diagram. It has no effect on the run.
struct Note {
  std::string id;
  std::string text;
  Position at;
  Position size;  ///< width and height of the note, px; 0, 0: fitted to the text
  friend bool operator==(const Note&, const Note&) = default;
};

/// A plot of an output over time that the editor draws in the diagram. It has no effect on the run.
struct ProbeMark {
  std::string pin;  ///< the output to plot, "id.pin"
  Position at;
  std::vector<std::uint32_t> components;  ///< indices of the plotted numbers of the payload; empty: the editor plots the first few
  friend bool operator==(const ProbeMark&, const ProbeMark&) = default;
};

struct Circuit {
  std::string name;
  std::string doc;
  std::optional<Position> inputs_at, outputs_at;  ///< positions of the boxes of the circuit's own pins in the editor
  std::vector<BoundaryPin> inputs;
  std::vector<BoundaryPin> outputs;
  std::vector<BoundaryParameter> parameters;
  std::vector<Instance> lsis;
  std::vector<Wire> wires;
  std::vector<Note> notes;        ///< notes shown in the editor; no effect on the run
  std::vector<ProbeMark> probes;  ///< plots shown in the editor; no effect on the run
  std::vector<Circuit> circuits;  ///< definitions of nested circuits, which `lsis` use by name
  friend bool operator==(const Circuit&, const Circuit&) = default;
};

/// Reads the JSON text of a circuit (docs/circuit.md); circuits of earlier versions are converted. Reports all problems, each with its
/// JSON path.
/// @param location  start of the JSON paths in errors, for example "circuit"
[[nodiscard]] Result<Circuit> read_circuit(std::string_view text, std::string_view location = "circuit");

/// Writes the canonical JSON text: entries in the order of `circuit`, one pin, LSI or wire per line, and a final newline. Numbers read back
/// to the same bits.
[[nodiscard]] std::string write_circuit(const Circuit& circuit);

}  // namespace ugoki::circuit
