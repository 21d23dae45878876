#include "ugoki/studio/simulated_part.h"

#include "ugoki/content/flatten.h"

namespace ugoki::studio {

void remove_display(circuit::Circuit& circuit) {
  circuit.doc.clear();
  circuit.inputs_at.reset();
  circuit.outputs_at.reset();
  circuit.notes.clear();
  circuit.probes.clear();
  for (circuit::Instance& lsi : circuit.lsis) {
    lsi.label.clear();
    lsi.note.clear();
    lsi.at = {};
  }
  for (circuit::Circuit& inner : circuit.circuits) remove_display(inner);
}

void remove_display(content::Scenario& scenario) {
  scenario.look = {};
  content::for_each_scenario(scenario, [](content::Scenario& s) {
    s.camera = {};
    s.cameras.clear();
    s.shots.clear();
    for (content::ScenarioCharacter& c : s.characters) {
      c.color = content::ScenarioCharacter().color;
      c.material = {};
    }
  });
}

}  // namespace ugoki::studio
