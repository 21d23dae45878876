#pragma once
// From the variables of an FMU to the pins and parameters of an LSI.

#include <string>
#include <vector>

#include "ugoki/circuit/lsi_class.h"
#include "ugoki/fmi/model_description.h"

namespace ugoki::fmi {

/// How a number lies in memory on its way through the interface. b32: FMI 2.0's Boolean, b8: that of FMI 3.0.
enum class Storage : std::uint8_t { f64, f32, i8, u8, i16, u16, i32, u32, i64, u64, b8, b32 };
[[nodiscard]] std::size_t bytes_of(Storage storage);
[[nodiscard]] Storage storage_of(VariableType type, int version);

/// A variable and the pin that stands for it.
struct PinBinding {
  Storage storage = Storage::f64;
  ValueReference reference = 0;
  std::uint32_t pin = 0;
  std::uint32_t count = 1;  ///< numbers
  bool discrete = false;    ///< changes at events only
};

/// A variable and the numbers of Call::parameters that stand for it, or its text.
struct ParameterBinding {
  Storage storage = Storage::f64;
  ValueReference reference = 0;
  std::uint32_t first = 0;            ///< in Call::parameters
  std::uint32_t count = 1;            ///< numbers
  std::vector<double> start;          ///< what the FMU has by itself; not set as long as it stays so
  std::vector<std::int64_t> choices;  ///< a choice: values of its words, by index
  std::string name;                   ///< of the LSI's parameter
  bool text = false, tunable = false;
};

/// An LSI without its functions, and what its pins and parameters are in the FMU.
struct Declaration {
  circuit::LsiClass lsi_class;
  std::vector<PinBinding> inputs, outputs;
  std::vector<ParameterBinding> parameters;
  int logging = -1;  ///< offset in Call::parameters of the parameter of this name, or -1
};

struct Declarations {
  std::vector<Declaration> classes;  ///< the FMU; and where it has variables inside, once more with all of them as outputs
  std::vector<std::string> notes;    ///< sentences: what could not become a pin or a parameter, and what to know
};

[[nodiscard]] Declarations declare(const ModelDescription& description);

/// The name of a pin or parameter for a variable: "body.h" becomes "body:h", for a point ends the name of an LSI.
[[nodiscard]] std::string pin_name(std::string_view variable);

}  // namespace ugoki::fmi
