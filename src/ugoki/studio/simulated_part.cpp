#include "ugoki/studio/simulated_part.h"

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
  scenario.camera = {};
  scenario.look = {};
  scenario.cameras.clear();
  scenario.shots.clear();
  for (content::ScenarioCharacter& c : scenario.characters) {
    c.color = content::ScenarioCharacter().color;
    c.material = {};
  }
}

}  // namespace ugoki::studio
