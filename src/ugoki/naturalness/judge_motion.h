#pragma once
// Measures of naturalness of recorded motions: contacts are detected, and ground forces and joint torques follow from inverse dynamics.

#include "ugoki/motion/motion.h"
#include "ugoki/naturalness/report.h"

namespace ugoki::naturalness {

struct JudgeOptions {
  double gravity = 9.81;  ///< m/s^2
  double friction = 0.8;  ///< Coulomb coefficient of the ground
  double ground = 0;      ///< m
};

/// Measures a motion without simulation. A cyclic motion is repeated until it lasts 4 s. Accelerations are those of the motion filtered at
/// 6 Hz, scaled with 1 / sqrt(size). Only feet bear load. O(frames (links + contact points)).
[[nodiscard]] Report judge_motion(const Mechanism& mechanism, const Motion& motion, const JudgeOptions& options = {});

}  // namespace ugoki::naturalness
