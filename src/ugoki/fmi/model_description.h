#pragma once
// Reader of modelDescription.xml, which describes an FMU (FMI 2.0 and 3.0). It reads the parts that an importer of co-simulation needs.
// Names follow the standard: fmi-standard.org, "Functional Mock-up Interface", versions 2.0 and 3.0.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "ugoki/base/result.h"

namespace ugoki::fmi {

using ValueReference = std::uint32_t;

/// Type of a variable. Real of FMI 2.0 is float64, Integer is int32.
enum class VariableType : std::uint8_t {
  float64,
  float32,
  int8,
  uint8,
  int16,
  uint16,
  int32,
  uint32,
  int64,
  uint64,
  boolean,
  enumeration,
  string,
  binary,
  clock
};
enum class Causality : std::uint8_t { parameter, calculated_parameter, structural_parameter, input, output, local, independent };
enum class Variability : std::uint8_t { constant, fixed, tunable, discrete, continuous };

/// An enumeration of the TypeDefinitions: (word, value) of each item.
struct EnumerationType {
  std::string name;
  std::vector<std::pair<std::string, std::int64_t>> items;
};

/// A variable of the FMU: a scalar or, in FMI 3.0, an array.
struct Variable {
  std::string name, description, unit, display_unit;
  ValueReference reference = 0;
  VariableType type = VariableType::float64;
  Causality causality = Causality::local;
  Variability variability = Variability::continuous;
  std::optional<double> minimum, maximum;
  std::vector<double> start;          ///< start values: one for each element, or one for all; booleans 0 or 1; empty: none
  std::vector<std::string> texts;     ///< start values of a string variable
  std::vector<std::uint64_t> extent;  ///< elements of each dimension, from the start values of structural parameters; empty: a scalar
  int enumeration = -1;               ///< index into ModelDescription::enumerations, or -1
  int line = 0;                       ///< line number in the file, from 1

  [[nodiscard]] bool is_array() const { return !extent.empty(); }
  [[nodiscard]] std::uint64_t count() const;  ///< number of elements of the variable; at most 2^40
};

/// Element DefaultExperiment: suggested settings of a simulation.
struct Experiment {
  std::optional<double> start, stop, tolerance, step;  ///< times in s; `tolerance` is relative
};

/// Content of modelDescription.xml.
struct ModelDescription {
  int version = 2;      ///< version of FMI: 2 or 3
  std::string written;  ///< attribute fmiVersion as written in the file: "2.0"
  std::string name, token, description, model_version, tool;
  std::string identifier;  ///< modelIdentifier of the co-simulation: a C identifier, the name of the binary
  bool needs_execution_tool = false, only_once_per_process = false;
  bool variable_step = false, saves_state = false, serializes_state = false, event_mode = false;
  std::optional<double> internal_step;  ///< attribute fixedInternalStepSize (FMI 3.0), s
  std::vector<std::string> log_categories;
  Experiment experiment;
  std::vector<EnumerationType> enumerations;
  std::vector<Variable> variables;
  std::vector<std::string> notes;  ///< sentences about repeated identical declarations, which were read once
};

/// Reads a model description. Reports up to 20 problems.
/// A declaration that is repeated with the same content is read once and noted.
/// Errors (location: "name:line"): the text is not XML, is not of FMI 2.0 or 3.0, has no co-simulation, or contradicts itself.
/// @param location for messages: "BouncingBall.fmu/modelDescription.xml"
[[nodiscard]] Result<ModelDescription> read_model_description(std::string_view xml, std::string_view location);

/// Name of a type in the standard: "Integer" in version 2, "Float64" in version 3.
[[nodiscard]] std::string_view name_of(VariableType type, int version);

}  // namespace ugoki::fmi
