#pragma once
// Variables of a scenario: numbers and switches that rules compare and change, for example the points of a game.
// docs/scenario.md describes the JSON form.

#include <string>
#include <string_view>

#include "ugoki/base/result.h"

namespace ugoki::content {

class Fields;
struct Scenario;

/// Largest magnitude of a value: sums of steps of 1e-6 remain exact to 1e-7.
inline constexpr double max_variable = 1e9;

enum class VariableKind {
  number,
  switch_  ///< 0: off, 1: on
};

struct ScenarioVariable {
  std::string id, name;
  VariableKind kind = VariableKind::number;
  double initial = 0;                                      ///< value at the start
  double minimum = -max_variable, maximum = max_variable;  ///< bounds that rules cannot pass (number)
  std::string unit;                                        ///< text behind the value, for example "%"
  bool shown = true;                                       ///< viewers show the value while the content plays
  friend bool operator==(const ScenarioVariable&, const ScenarioVariable&) = default;
};

/// Returns the variable with this id, or null.
[[nodiscard]] const ScenarioVariable* find_variable(const Scenario& scenario, std::string_view id);

/// Reads the JSON form. Absent fields keep their value in `variable`.
void read_variable(Fields& fields, ScenarioVariable& variable);
/// Adds the problems of the variable: values out of range, texts that are too long. Ids and names are checked by check_scenario().
void check_variable(const ScenarioVariable& variable, const std::string& location, Error& problems);

/// Removes a variable, and the rules that compare or change it.
void remove_variable(Scenario& scenario, const std::string& id);

}  // namespace ugoki::content
