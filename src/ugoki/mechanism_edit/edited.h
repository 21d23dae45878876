#pragma once
// Result of an operation on a mechanism.

#include <string>
#include <vector>

#include "ugoki/mechanism/mechanism.h"

namespace ugoki {

struct Edited {
  MechanismPtr mechanism;
  std::vector<std::string> report;  ///< sentences for the user about parts that were moved, renamed or dropped
};

}  // namespace ugoki
