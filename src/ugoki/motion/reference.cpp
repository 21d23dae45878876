#include "ugoki/motion/reference.h"

#include "ugoki/motion/feet_on_floor.h"
#include "ugoki/motion/jumps.h"

namespace ugoki {

SmoothMotion make_reference(const Motion& motion, const Mechanism& mechanism, double floor) {
  std::vector<double> cutoffs;
  for (const Link& link : mechanism.links()) {
    const bool light = link.label.starts_with("hand") || link.label.starts_with("fingers") || link.label.starts_with("thumb");
    cutoffs.push_back(light ? 15.0 : 6.0);
  }
  return SmoothMotion(with_feet_on_floor(without_jumps(motion, mechanism), mechanism, floor), mechanism, cutoffs);
}

}  // namespace ugoki
