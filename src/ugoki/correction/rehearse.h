#pragma once
// Physics correction by sampling: a simulation in which the joints alone reproduce the motion. For motions whose contacts are not known
// and are not feet: rolls, falls, motions on hands and back. docs/design/correction.md describes the method.

#include <cstdint>
#include <functional>

#include "ugoki/motion/motion.h"

namespace ugoki::correction {

struct RehearseOptions {
  double gravity = 9.81;   ///< m/s^2, downwards
  double friction = 0.9;   ///< Coulomb coefficient of the ground
  int samples = 500;       ///< simulations of each window of 0.1 s
  int kept = 25;           ///< states that each window passes on to the next one
  std::uint64_t seed = 1;  ///< of the random offsets; equal seeds give equal bits
  /// Called with the fraction of the work that is done, 0 to 1. The work is cancelled if it returns false. May be empty.
  std::function<bool(double)> progress = {};
};

struct RehearseReport {
  double assist_bw =
      0;  ///< body weights: rms of the root assist that the given motion needs; moments are divided by MotionControl::lever()
  double change_deg = 0;    ///< rms rotation of the joints from the given motion, degrees
  double root_move_cm = 0;  ///< rms displacement of the root from the given motion, cm
  double reached = 0;       ///< s: time until which the simulation follows the motion
};

/// Reproduces a motion by the torques of its joints, within their limits, over the floor z = 0. All links can touch the floor. O(frames *
/// samples): about 7 s of processor time for a second of motion. Errors: the motion does not fit the mechanism; the root is not floating;
/// options out of range; the body loses the motion (with the time); cancelled.
[[nodiscard]] Result<Motion> rehearse_motion(const MechanismPtr& mechanism, const Motion& motion, const RehearseOptions& options = {},
                                             RehearseReport* report = nullptr);

}  // namespace ugoki::correction
