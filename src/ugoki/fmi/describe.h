#pragma once
// modelDescription.xml of an exported circuit. Internal to fmi.

#include <string>

#include "ugoki/circuit/circuit.h"
#include "ugoki/fmi/interface.h"

namespace ugoki::fmi {

struct DescribeRequest {
  int version = 3;
  double dt = 0.001;  ///< s
  std::string identifier, token;
};

[[nodiscard]] std::string write_model_description(const circuit::Circuit& circuit, const Interface& interface,
                                                  const DescribeRequest& request);

}  // namespace ugoki::fmi
