#pragma once
// What an operation on a mechanism gives.

#include <string>
#include <vector>

#include "ugoki/mechanism/mechanism.h"

namespace ugoki {

struct Edited {
  MechanismPtr mechanism;
  std::vector<std::string> report;  ///< sentences for people: what was moved, renamed, left out
};

}  // namespace ugoki
