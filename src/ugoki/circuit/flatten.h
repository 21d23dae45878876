#pragma once
// Converts a circuit to a flat list of LSIs whose inputs refer to the outputs that feed them. Nested circuits are expanded; names, wires,
// values and parameters are checked against the library.

#include <string>
#include <vector>

#include "ugoki/circuit/circuit.h"
#include "ugoki/circuit/library.h"

namespace ugoki::circuit {

/// An output of an LSI of the flattened circuit.
struct Source {
  int lsi = -1;  ///< index into FlatCircuit::lsis; -1: none
  int pin = 0;   ///< index of the output
  friend bool operator==(const Source&, const Source&) = default;
};

struct FlatInput {
  std::vector<Source> sources;  ///< at most one source; for pins declared `multiple` any number, sorted by (lsi, pin)
  std::vector<double> value;    ///< fixed value that the circuit specifies instead of a wire; empty: none
};

struct FlatLsi {
  std::string id;  ///< id with the ids of the enclosing circuits: "arm/elbow/gain"
  const LsiClass* lsi_class = nullptr;
  std::string location;           ///< JSON path of the LSI in the circuit
  std::uint32_t every = 1;        ///< runs at each `every`-th tick; 0: on demand only
  std::vector<Value> parameters;  ///< values of all parameters of the class, in the order of declaration
  std::vector<FlatInput> inputs;  ///< sources or fixed value of each input of the class, in the order of declaration
};

struct FlatPort {
  std::string name;
  Source source;  ///< output that provides the value; an input of the circuit has a placeholder LSI without functions
};

struct FlatCircuit {
  std::vector<FlatLsi> lsis;     ///< sorted by id, so that indices do not depend on the order in the file
  std::vector<FlatPort> inputs;  ///< inputs of the outermost circuit
  std::vector<FlatPort> outputs;
};

/// Returns the flat form of the circuit. All errors are added to `problems`; if there are any, the result must not be used.
/// @param library  must outlive the result
[[nodiscard]] FlatCircuit flatten(const Circuit& circuit, const Library& library, Error& problems);

}  // namespace ugoki::circuit
