#pragma once
// The variables of a circuit that is exported as an FMU. The exporter writes them into modelDescription.xml; the FMU's binary (apps/fmu)
// sets and gets them. Both get them from make_interface(), so the description and the binary always agree.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/circuit/circuit.h"
#include "ugoki/circuit/interpreter.h"
#include "ugoki/circuit/library.h"

namespace ugoki::fmi {

/// Kind of object in the circuit from which an FMU variable is made.
enum class InterfaceRole : std::uint8_t {
  time,
  input,     ///< input pin of the circuit
  device,    ///< output of a device LSI (a key, an axis) that the host program sets; an input of the FMU
  output,    ///< output pin of the circuit
  parameter  ///< parameter of the circuit
};
/// Type of a variable. real: Real or Float64; whole: an integer, Integer or Int64; choice: Enumeration.
enum class InterfaceType : std::uint8_t { real, whole, boolean, text, choice };

/// One variable. An array is one variable of FMI 3.0, and `count` scalar variables of FMI 2.0.
struct InterfaceVariable {
  std::string name, doc, unit;
  InterfaceRole role = InterfaceRole::input;
  InterfaceType type = InterfaceType::real;
  std::uint32_t reference = 0;     ///< value reference; in FMI 2.0 that of the first element, with those of the others following
  std::uint32_t count = 1;         ///< number of elements
  bool array = false;              ///< true: an array, possibly of one element
  std::string target;              ///< name of the pin or parameter of the circuit; "id.pin" of a device
  std::vector<double> start;       ///< [count] start values; for a choice, 1 is its first word
  std::string text;                ///< start value of a text variable
  std::vector<std::string> words;  ///< names of the values of a choice
  std::optional<double> minimum, maximum;
  bool tunable = false;    ///< true: a parameter that may change while the circuit runs
  bool on_demand = false;  ///< true: an output of an LSI that runs on demand only
  std::string source;      ///< for an output: the LSI output that provides its value, as "id.pin" of the flattened circuit
  std::vector<std::uint32_t>
      depends;  ///< for an output: indices in Interface::variables of the inputs and devices that affect it in the same tick
  std::vector<std::string> ends;  ///< for a parameter: the LSI parameters that it sets, as "id.parameter" of the flattened circuit
};

/// The FMU variables of a circuit.
struct Interface {
  std::vector<InterfaceVariable> variables;
  std::vector<std::string> notes;  ///< sentences about pins and parameters that cannot be variables
};

/// Makes the variables of a circuit: time, inputs, devices, outputs, parameters, with ascending value references from 0.
/// @param running interpreter built from `circuit` with `library`; supplies the sizes of pins and the device slots
[[nodiscard]] Interface make_interface(const circuit::Circuit& circuit, const circuit::Library& library, circuit::Interpreter& running);

/// Sets a boundary parameter of a circuit: writes `value` into the LSIs that the parameter leads to.
/// @param value must be of the kind of these LSIs' parameters
void set_parameter(circuit::Circuit& circuit, std::string_view parameter, const circuit::Value& value);

}  // namespace ugoki::fmi
