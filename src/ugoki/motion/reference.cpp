#include "ugoki/motion/reference.h"

#include <algorithm>

#include "ugoki/motion/feet_on_floor.h"
#include "ugoki/motion/jumps.h"
#include "ugoki/motion/torques.h"

namespace ugoki {

SmoothMotion make_reference(const Motion& motion, const Mechanism& mechanism, double floor) {
  const bool computed = is_computed(motion);
  // Legs with paws reach the limits of their joints in nearly every step, where their accelerations jump.
  const bool paws = std::ranges::any_of(mechanism.links(), [](const Link& link) { return link.label.starts_with("paw"); });
  if (computed && !paws) return SmoothMotion(motion, mechanism, 0);
  std::vector<double> cutoffs;
  for (const Link& link : mechanism.links()) {
    const bool light = link.label.starts_with("hand") || link.label.starts_with("fingers") || link.label.starts_with("thumb");
    cutoffs.push_back(light ? 15.0 : 6.0);
  }
  if (computed) return SmoothMotion(motion, mechanism, cutoffs);
  return SmoothMotion(with_feet_on_floor(without_jumps(motion, mechanism), mechanism, floor), mechanism, cutoffs);
}

}  // namespace ugoki
