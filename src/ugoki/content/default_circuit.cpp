#include "ugoki/content/default_circuit.h"

#include "ugoki/circuit/circuit.h"

namespace ugoki::content {

std::string default_circuit(const Scenario& scenario) {
  circuit::Circuit c;
  c.name = scenario.name;
  return circuit::write_circuit(c);
}

}  // namespace ugoki::content
