#pragma once
// Inverse kinematics of a whole mechanism: moves joints so that several links reach their goals, loops stay closed and limits are kept,
// with as little change of the pose as possible. docs/design/posing.md describes the equations.

#include <cstdint>
#include <span>
#include <vector>

#include "ugoki/mechanism/mechanism.h"

namespace ugoki::posing {

/// A point of a link that shall reach a position, optionally with an orientation of the link.
struct PoseGoal {
  int link = 0;
  Vec3 point;                 ///< m, in the link's frame
  Vec3 target;                ///< m, world
  bool turn = false;          ///< true: the link shall also have the orientation R
  Mat3 R = Mat3::identity();  ///< orientation of the link in the world
};

struct PoseSolverOptions {
  std::vector<std::uint8_t> moves = {};  ///< [links] 1: the link's joint may move; empty: all joints
  bool limits = true;                    ///< false: joints may pass their limits
  double stiffness = 0.01;               ///< m/rad: a joint rotation of 1 rad counts as much as a position error of this length
  int iterations = 60;
};

/// Moves joints such that the sum of squared errors of all goals and loops, plus the squared displacement from the initial pose times
/// stiffness^2, is minimal (Levenberg-Marquardt method; limits by projection). Translations of a joint count as rotations of
/// 1 rad per `lever`; the root is stiffer than other joints.
/// @param q [nq, in and out]
/// @return maximum position error of the goals, m
/// O(iterations * DOFs^3)
double solve_pose(const Mechanism& mechanism, std::span<const PoseGoal> goals, const PoseSolverOptions& options, std::span<double> q);

/// Sets the coordinates of a joint to the closest ones within its limits. Floating joints have no limits. @return true if they changed
bool clamp_to_limits(const Joint& joint, double* q);
/// Sets the displacement of one DOF from the neutral position (see joint_displacement()), rad | m. No effect on floating joints.
void set_displacement(const Joint& joint, int dof, double value, double* q);

}  // namespace ugoki::posing
