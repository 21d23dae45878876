#pragma once
// The part of a document that the simulation depends on. A change of anything else does not restart the simulation. Internal to studio.

#include "ugoki/circuit/circuit.h"
#include "ugoki/content/scenario.h"

namespace ugoki::studio {

/// Removes everything that has no effect on the circuit's values: notes, labels, positions and probes.
void remove_display(circuit::Circuit& circuit);
/// Removes everything that only changes how the content is drawn: look, cameras, shots and materials.
void remove_display(content::Scenario& scenario);

}  // namespace ugoki::studio
