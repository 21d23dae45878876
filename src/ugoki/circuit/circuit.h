#pragma once
// A circuit as data: the form people edit and save. Nothing here is checked against a library; building an interpreter does that.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/circuit/lsi_class.h"

namespace ugoki::circuit {

inline constexpr int circuit_version = 1;

struct Position {
  double x = 0, y = 0;
  friend bool operator==(const Position&, const Position&) = default;
};

using NamedValue = std::pair<std::string, Value>;

/// One LSI (or circuit used as an LSI) in a circuit.
struct Instance {
  std::string id;                      ///< stable, unique in its circuit, letters, digits, `_` and `-`
  std::string type;                    ///< name of a circuit in `circuits`, or of an LSI class
  std::string label;                   ///< for people; may be empty
  std::string note;                    ///< comment; may be empty
  Position at;                         ///< in the editor
  std::uint32_t every = 1;             ///< runs at each `every`-th tick; 0: only when the host asks (Interpreter::refresh)
  std::vector<NamedValue> parameters;  ///< by name
  std::vector<NamedValue> values;      ///< of inputs without wire, by pin
  friend bool operator==(const Instance&, const Instance&) = default;
};

/// From an output to an input, both written "id.pin".
struct Wire {
  std::string from, to;
  friend bool operator==(const Wire&, const Wire&) = default;
};

/// A pin of the circuit itself.
struct BoundaryPin {
  std::string name;
  PinTypeId type = PinTypeId::scalar;
  std::string unit;
  std::string doc;
  std::vector<std::string> ends;  ///< inputs: the "id.pin" it leads to; outputs: the one "id.pin" it comes from (none: it does not run yet)
  friend bool operator==(const BoundaryPin&, const BoundaryPin&) = default;
};

/// A parameter of the circuit itself: sets parameters inside.
struct BoundaryParameter {
  std::string name;
  std::string doc;
  std::vector<std::string> ends;  ///< "id.parameter"
  friend bool operator==(const BoundaryParameter&, const BoundaryParameter&) = default;
};

/// A note stuck into a circuit, for people only.
struct Note {
  std::string id;
  std::string text;
  Position at;
  Position size;  ///< width, height; 0, 0: as large as its text
  friend bool operator==(const Note&, const Note&) = default;
};

/// A curve of an output that the editor draws beside the LSIs.
struct ProbeMark {
  std::string pin;  ///< "id.pin"
  Position at;
  std::vector<std::uint32_t> components;  ///< numbers of the payload; none: the first few
  friend bool operator==(const ProbeMark&, const ProbeMark&) = default;
};

struct Circuit {
  std::string name;
  std::string doc;
  std::optional<Position> inputs_at, outputs_at;  ///< of the circuit's own pins in the editor
  std::vector<BoundaryPin> inputs;
  std::vector<BoundaryPin> outputs;
  std::vector<BoundaryParameter> parameters;
  std::vector<Instance> lsis;
  std::vector<Wire> wires;
  std::vector<Note> notes;        ///< nothing runs these
  std::vector<ProbeMark> probes;  ///< nor these
  std::vector<Circuit> circuits;  ///< used inside as LSIs, by name
  friend bool operator==(const Circuit&, const Circuit&) = default;
};

/// The text of a circuit (JSON, docs/circuit.md). All problems are reported, each with its JSON path.
/// @param place what the text is called in errors, for example "circuit"
[[nodiscard]] Result<Circuit> read_circuit(std::string_view text, std::string_view place = "circuit");

/// The canonical text: order kept, one pin, LSI or wire a line, numbers that read back to the same bits, final newline.
[[nodiscard]] std::string write_circuit(const Circuit& circuit);

}  // namespace ugoki::circuit
