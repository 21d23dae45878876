#pragma once
// Faults of naturalness that the faults of tests/correction do not contain. Each is planted in a clean motion.

#include <string>
#include <vector>

#include "ugoki/motion/motion.h"
#include "ugoki/naturalness/measure_list.h"

namespace ugoki::naturalness {

struct Planted {
  std::string name;
  Motion (*plant)(const Mechanism&, const Motion&);
  std::vector<MeasureId> flagged;  ///< at least one of these measures must be bad
};

/// Faults of walks.
[[nodiscard]] const std::vector<Planted>& walk_faults();
/// Faults of motions with flights.
[[nodiscard]] const std::vector<Planted>& flight_faults();

}  // namespace ugoki::naturalness
