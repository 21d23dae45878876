#pragma once
// Plants one fault each in a clean motion, as bad captures and careless keys contain them.

#include <string>
#include <vector>

#include "ugoki/motion/motion.h"

namespace ugoki::correction {

struct Fault {
  std::string name;
  Motion (*plant)(const Mechanism&, const Motion&);
};

/// The ten faults. "gravity" changes only motions with flights.
[[nodiscard]] const std::vector<Fault>& faults();

}  // namespace ugoki::correction
