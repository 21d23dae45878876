#pragma once
// Makes the pins and parameters of an LSI from the variables of an FMU.

#include <string>
#include <vector>

#include "ugoki/circuit/lsi_class.h"
#include "ugoki/fmi/model_description.h"

namespace ugoki::fmi {

/// Type of a value in the calls of an FMU. b32: Boolean of FMI 2.0 (int); b8: Boolean of FMI 3.0 (bool).
enum class Storage : std::uint8_t { f64, f32, i8, u8, i16, u16, i32, u32, i64, u64, b8, b32 };
[[nodiscard]] std::size_t bytes_of(Storage storage);
/// Type of a variable in the calls of an FMU. @param version version of FMI, 2 or 3
[[nodiscard]] Storage storage_of(VariableType type, int version);

/// Assignment of a variable of the FMU to a pin of the LSI.
struct PinBinding {
  Storage storage = Storage::f64;
  ValueReference reference = 0;
  std::uint32_t pin = 0;    ///< index among the inputs or outputs of the LSI
  std::uint32_t count = 1;  ///< number of values
  bool discrete = false;    ///< true: the variable may change at events only
};

/// A variable of the FMU that is a parameter of the LSI: values in Call::parameters, or a text.
struct ParameterBinding {
  Storage storage = Storage::f64;
  ValueReference reference = 0;
  std::uint32_t first = 0;            ///< index of the first value of the parameter in Call::parameters
  std::uint32_t count = 1;            ///< number of values
  std::vector<double> start;          ///< start values of the FMU; a parameter that equals them is not set; empty: unknown
  std::vector<std::int64_t> choices;  ///< only if the LSI's parameter is a choice: the FMU's value for each option
  std::string name;                   ///< name of the LSI's parameter; array: name of the first element's parameter
  bool text = false, tunable = false;
};

/// An LSI without its functions, and the variables of the FMU for its pins and parameters.
struct Declaration {
  circuit::LsiClass lsi_class;
  std::vector<PinBinding> inputs, outputs;
  std::vector<ParameterBinding> parameters;
  int logging = -1;  ///< index in Call::parameters of the added parameter "logging"; -1: the FMU has a parameter of this name itself
};

/// The declared LSIs of an FMU, with notes for the user.
struct Declarations {
  std::vector<Declaration> classes;  ///< one LSI; if the FMU has 1 ... 1000 local variables, also a second LSI that outputs them too
  std::vector<std::string> notes;    ///< sentences for the user about variables without pin or parameter, and about other limitations
};

/// Declares the LSIs of an FMU.
[[nodiscard]] Declarations declare(const ModelDescription& description);

/// Name of the pin or parameter for a variable. Every '.' becomes ':' ("body.h" becomes "body:h"), because in circuits a '.' separates the
/// id of an LSI from the name of a pin.
[[nodiscard]] std::string pin_name(std::string_view variable);

}  // namespace ugoki::fmi
