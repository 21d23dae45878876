#pragma once
// Writes the modelDescription.xml of an exported circuit. Internal to fmi.

#include <string>

#include "ugoki/circuit/circuit.h"
#include "ugoki/fmi/interface.h"

namespace ugoki::fmi {

struct DescribeRequest {
  int version = 3;                ///< version of FMI: 2 or 3
  double dt = 0.001;              ///< time between two ticks of the circuit, s
  std::string identifier, token;  ///< the attributes modelIdentifier, and guid (FMI 2.0) or instantiationToken (FMI 3.0)
};

/// @return the text of modelDescription.xml
[[nodiscard]] std::string write_model_description(const circuit::Circuit& circuit, const Interface& interface,
                                                  const DescribeRequest& request);

}  // namespace ugoki::fmi
