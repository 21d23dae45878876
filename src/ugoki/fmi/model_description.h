#pragma once
// modelDescription.xml of an FMU (FMI 2.0 and 3.0), as far as an importer of co-simulation needs it.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "ugoki/base/result.h"

namespace ugoki::fmi {

using ValueReference = std::uint32_t;

/// FMI 2.0's Real is float64, its Integer is int32.
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

struct EnumerationType {
  std::string name;
  std::vector<std::pair<std::string, std::int64_t>> items;
};

struct Variable {
  std::string name, description, unit, display_unit;
  ValueReference reference = 0;
  VariableType type = VariableType::float64;
  Causality causality = Causality::local;
  Variability variability = Variability::continuous;
  std::optional<double> minimum, maximum;
  std::vector<double> start;          ///< numbers as they stand there (one may mean all); booleans 0 or 1; empty: none
  std::vector<std::string> texts;     ///< start of strings
  std::vector<std::uint64_t> extent;  ///< of each dimension, with the start values of structural parameters; empty: a scalar
  int enumeration = -1;               ///< index of its type, or -1
  int line = 0;

  [[nodiscard]] bool is_array() const { return !extent.empty(); }
  [[nodiscard]] std::uint64_t count() const;  ///< of its numbers
};

struct Experiment {
  std::optional<double> start, stop, tolerance, step;  ///< s; tolerance relative
};

struct ModelDescription {
  int version = 2;      ///< 2 or 3
  std::string written;  ///< fmiVersion as it stands there
  std::string name, token, description, model_version, tool;
  std::string identifier;  ///< of the co-simulation: name of its binary, a C identifier
  bool needs_execution_tool = false, only_once_per_process = false;
  bool variable_step = false, saves_state = false, serializes_state = false, event_mode = false;
  std::optional<double> internal_step;  ///< s (FMI 3.0)
  std::vector<std::string> log_categories;
  Experiment experiment;
  std::vector<EnumerationType> enumerations;
  std::vector<Variable> variables;
};

/// Errors (place: "name:line"): it is no XML, not of FMI 2.0 or 3.0, has no co-simulation, or contradicts itself where that matters.
/// @param place for messages: "BouncingBall.fmu/modelDescription.xml"
[[nodiscard]] Result<ModelDescription> read_model_description(std::string_view xml, std::string_view place);

/// "Float64", "Integer": what the standard of this version calls it.
[[nodiscard]] std::string_view name_of(VariableType type, int version);

}  // namespace ugoki::fmi
