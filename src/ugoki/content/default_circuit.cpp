#include "ugoki/content/default_circuit.h"

#include <algorithm>

#include "ugoki/content/rule_circuit.h"
#include "ugoki/lsi/execution_circuit.h"

namespace ugoki::content {

namespace {

lsi::CircuitCharacter::Drive drive_of(ControlMode mode) {
  using enum lsi::CircuitCharacter::Drive;
  return mode == ControlMode::path ? path : mode == ControlMode::torque ? torque : control;
}

}  // namespace

std::string default_circuit(const Scenario& scenario) {
  const bool grips = std::ranges::any_of(scenario.events, [](const ScenarioEvent& e) { return e.type == EventType::grab; }) ||
                     std::ranges::any_of(scenario.rules, [](const Rule& r) { return r.action.type == ActionType::grab; });
  std::vector<lsi::CircuitCharacter> characters;
  for (const ScenarioCharacter& c : scenario.characters)
    characters.push_back({c.id, c.control.mode != ControlMode::passive && !c.track.empty(), c.control.tracking, c.control.balance,
                          c.control.assist_limit, !play_rules(scenario, c.id).empty(), drive_of(c.control.mode), c.control.swing, grips});
  circuit::Circuit made = lsi::make_execution_circuit(characters, scenario.step);
  add_rules(made, scenario);
  return circuit::write_circuit(made);
}

}  // namespace ugoki::content
