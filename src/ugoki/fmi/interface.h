#pragma once
// What a circuit shows to the outside as an FMU. The exporter describes it, the FMU's binary works with it: both make it from the circuit,
// so they cannot differ.

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

enum class InterfaceRole : std::uint8_t {
  time,
  input,     ///< of the circuit
  device,    ///< an output that the host feeds: a key, an axis
  output,    ///< of the circuit
  parameter  ///< of the circuit
};
/// whole: FMI 2.0 Integer, FMI 3.0 Int64.
enum class InterfaceType : std::uint8_t { real, whole, boolean, text, choice };

struct InterfaceVariable {
  std::string name, doc, unit;
  InterfaceRole role = InterfaceRole::input;
  InterfaceType type = InterfaceType::real;
  std::uint32_t reference = 0;  ///< value reference; of the first number in FMI 2.0, where each has one of its own
  std::uint32_t count = 1;      ///< numbers
  bool array = false;           ///< has an index, even if it is of one number
  std::string target;           ///< name of the circuit's pin or parameter; "id.pin" of a device
  std::vector<double> start;    ///< [count]; of a choice: 1 for its first word
  std::string text;             ///< start of a text
  std::vector<std::string> words;
  std::optional<double> minimum, maximum;
  bool tunable = false;                ///< a parameter that may change while it runs
  bool on_demand = false;              ///< an output of an LSI that runs on demand only
  std::string source;                  ///< an output: "id.pin" of the flat circuit
  std::vector<std::uint32_t> depends;  ///< an output: indices of variables (inputs, devices) that it shows in the same tick
  std::vector<std::string> ends;       ///< a parameter: "id.parameter" of the flat circuit
};

struct Interface {
  std::vector<InterfaceVariable> variables;
  std::vector<std::string> notes;  ///< pins that cannot be variables
};

/// @param running built of `circuit` with `library`: knows the sizes
[[nodiscard]] Interface make_interface(const circuit::Circuit& circuit, const circuit::Library& library, circuit::Interpreter& running);

/// Sets a parameter of the circuit itself in the circuit. @param value fits the kind of the parameters it leads to
void set_parameter(circuit::Circuit& circuit, std::string_view parameter, const circuit::Value& value);

}  // namespace ugoki::fmi
