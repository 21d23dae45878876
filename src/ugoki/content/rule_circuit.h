#pragma once
// LSIs of the generated execution circuit that evaluate the rules of a scenario.

#include <string>

#include "ugoki/circuit/circuit.h"
#include "ugoki/content/scenario.h"

namespace ugoki::content {

/// Adds the LSIs of all variables ("variable-ID") and of all rules that are on. Each condition is one LSI (keyboard, touch, closest pair,
/// ...), and so is the action: `play rule`, `push`, `grip rule` or `set variable`, with the id "rule-ID". The play rules of a character are
/// wired in series to its LSI `motion choice`; the first rule of the document has priority. Pushes and grips are wired in series between
/// `event` and `dynamics`. Rules that play motions of a character without the LSI `motion choice` are left out: it is passive, has no
/// clips, or balances without root assist.
/// @param circuit  result of make_execution_circuit() for the same scenario
void add_rules(circuit::Circuit& circuit, const Scenario& scenario);
/// Id of the LSI of a variable. Its output `value` is the value of the variable.
[[nodiscard]] std::string variable_lsi(const std::string& variable);

}  // namespace ugoki::content
