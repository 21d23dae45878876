#pragma once
// Inverse kinematics of one limb: moves its joints so that its end reaches a goal pose.

#include <span>

#include "ugoki/mechanism/mechanism.h"

namespace ugoki {

struct ReachOptions {
  double damping = 0.02;  ///< m/rad, damping of the least squares; position errors [m] far below this value do not bend a straight limb
  bool keep = false;      ///< true: damping pulls the joints towards their initial values, so that errors which only a large
                          ///< joint motion could remove remain; false: damping limits each iteration's step only
  double lever = 0.3;     ///< m: an orientation error [rad] times this length counts as a position error
  double enough = 1e-5;   ///< m: the iteration stops when the error is below this length
  int iterations = 6;     ///< maximum number of iterations
  int held = -1;          ///< index of a link of the limb whose joint is not moved; -1: none
};

/// Moves the joints of the limb so that its end approaches X_goal (damped least squares, Buss 2009). A step moves a hinge at most to its
/// limit; a hinge that is already beyond its limit does not move farther out.
/// @param limb links from the limb's base to its end; the end is the frame of the last link
/// @param X_goal goal pose of the end in the world
/// @param q [nq, in and out]  @param X_WB [links, in and out] poses at q; only those of the limb's links are updated
/// @return remaining error [m]: norm of the position error and of the orientation error times the lever
double reach(const Mechanism& mechanism, std::span<const int> limb, const Pose& X_goal, const ReachOptions& options, double* q,
             std::span<Pose> X_WB);

}  // namespace ugoki
