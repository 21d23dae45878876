#include "ugoki/motion/markers.h"

#include <algorithm>

namespace ugoki {

int MarkerMotion::find(const std::string& label) const {
  const auto it = std::find(labels.begin(), labels.end(), label);
  return it == labels.end() ? -1 : static_cast<int>(it - labels.begin());
}

double seen_share(const MarkerMotion& motion) {
  if (motion.residuals.empty()) return 0;
  const auto seen = std::count_if(motion.residuals.begin(), motion.residuals.end(), [](float r) { return r >= 0; });
  return static_cast<double>(seen) / static_cast<double>(motion.residuals.size());
}

}  // namespace ugoki
