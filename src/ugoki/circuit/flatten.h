#pragma once
// From the circuit as data to a flat list of LSIs whose inputs know their sources: nested circuits opened, names resolved, wires,
// values and parameters checked.

#include <string>
#include <vector>

#include "ugoki/circuit/circuit.h"
#include "ugoki/circuit/library.h"

namespace ugoki::circuit {

/// An output of a flat LSI.
struct Source {
  int lsi = -1;
  int pin = 0;
  friend bool operator==(const Source&, const Source&) = default;
};

struct FlatInput {
  std::vector<Source> sources;  ///< none, one, or (multiple pins) several in the order of (lsi, pin)
  std::vector<double> value;    ///< what the circuit gives instead of a wire; may be empty
};

struct FlatLsi {
  std::string id;  ///< with the ids of the circuits around it: "arm/elbow/gain"
  const LsiClass* lsi_class = nullptr;
  std::string place;  ///< JSON path
  std::uint32_t every = 1;
  std::vector<Value> parameters;  ///< all of the class, in the order of declaration
  std::vector<FlatInput> inputs;  ///< [inputs of the class]
};

struct FlatPort {
  std::string name;
  Source source;  ///< inputs of the circuit: the LSI that stands for it
};

struct FlatCircuit {
  std::vector<FlatLsi> lsis;     ///< sorted by id, so that an index is a stable rank
  std::vector<FlatPort> inputs;  ///< of the outermost circuit
  std::vector<FlatPort> outputs;
};

/// Opens the circuit; everything wrong with it goes into `problems` (the result is then of no use).
/// @param library outlives the result
[[nodiscard]] FlatCircuit flatten(const Circuit& circuit, const Library& library, Error& problems);

}  // namespace ugoki::circuit
