#pragma once
// A simulation of a motion in which motion control may use any root assist. Internal to correction.

#include <vector>

#include "ugoki/motion/motion.h"
#include "ugoki/world/world.h"

namespace ugoki::correction {

/// States and drive torques of a simulation, step by step.
struct RecordedRun {
  double step = 0.002;                   ///< s
  std::vector<std::vector<double>> q;    ///< [steps + 1][nq]
  std::vector<std::vector<double>> v;    ///< [steps + 1][nv] m/s | rad/s
  std::vector<std::vector<double>> tau;  ///< [steps][nv] N m: of the joints; zero for the root
  double assist_bw = 0;                  ///< body weights: rms of the root assist
  [[nodiscard]] int steps() const { return static_cast<int>(tau.size()); }
};

/// Simulates a motion by motion control with an unlimited root assist. All planted points of all links bear load. The contacts of the
/// result are therefore possible, and its torques are nearly those that the motion needs. Returns fewer steps if a step fails.
/// @param world the mechanism alone over its ground @param steps number of steps; after its end, the motion rests
[[nodiscard]] RecordedRun run_assisted(const MechanismPtr& mechanism, const Motion& motion, const world::World& world, int steps);

}  // namespace ugoki::correction
