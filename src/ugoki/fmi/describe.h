#pragma once
// Writes the modelDescription.xml of an exported circuit. Internal to fmi.

#include <string>

#include "ugoki/circuit/circuit.h"
#include "ugoki/fmi/interface.h"

namespace ugoki::fmi {

struct DescribeRequest {
  int version = 3;                ///< of FMI: 2 or 3
  double dt = 0.001;              ///< s, between two ticks of the circuit
  std::string identifier, token;  ///< modelIdentifier; guid or instantiationToken
};

/// @return the text of the XML file
[[nodiscard]] std::string write_model_description(const circuit::Circuit& circuit, const Interface& interface,
                                                  const DescribeRequest& request);

}  // namespace ugoki::fmi
