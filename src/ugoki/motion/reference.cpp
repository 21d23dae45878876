#include "ugoki/motion/reference.h"

#include <algorithm>

#include "ugoki/motion/feet_on_floor.h"
#include "ugoki/motion/jumps.h"
#include "ugoki/motion/torques.h"
#include "ugoki/motion/upsample.h"

namespace ugoki {
namespace {

// Hz. With 10, 15 and 20 Hz, computed walks of 1.0 to 1.4 m/s hold for 60 s up a slope of 10 degrees; with 8 Hz, and without a filter, two
// of these five fall. With 6 Hz, a person on a path lags behind it by a tenth.
constexpr double computed_cutoff = 15;

// Frames per second. Feet are moved to the floor, velocities computed and motions filtered alike for all files of at least this rate; 6 Hz
// cannot be filtered in a motion of 12 frames per second, and a foot is below the floor between its frames.
constexpr double min_rate = 120;

}  // namespace

SmoothMotion make_reference(const Motion& motion, const Mechanism& mechanism, double floor) {
  // Legs with paws reach the limits of their joints in nearly every step, where their accelerations jump, also in computed motions.
  const bool paws = std::ranges::any_of(mechanism.links(), [](const Link& link) { return link.label.starts_with("paw"); });
  if (is_computed(motion) && !paws) return SmoothMotion(motion, mechanism, computed_cutoff);
  std::vector<double> cutoffs;
  for (const Link& link : mechanism.links()) {
    const bool light = link.label.starts_with("hand") || link.label.starts_with("fingers") || link.label.starts_with("thumb");
    cutoffs.push_back(light ? 15.0 : 6.0);
  }
  if (is_computed(motion)) return SmoothMotion(motion, mechanism, cutoffs);
  const Motion fine = upsampled(without_jumps(motion, mechanism), mechanism, min_rate);
  return SmoothMotion(with_feet_on_floor(fine, mechanism, floor), mechanism, cutoffs);
}

}  // namespace ugoki
