#pragma once
// Inverse kinematics of one limb: its joints are turned until its end is where it shall be.

#include <span>

#include "ugoki/mechanism/mechanism.h"

namespace ugoki {

struct ReachOptions {
  double damping = 0.02;  ///< m: a straight limb is not bent for less
  bool keep = false;      ///< damping holds the joints to where they were at first, not only to where the step before left them:
                          ///< what only a great turn could mend stays
  double lever = 0.3;     ///< m: an error of the end's orientation counts as one of its place at this distance
  double enough = 1e-5;   ///< m: nearer need not be
  int iterations = 6;
  int held = -1;  ///< link of the limb whose own joint is left alone; -1: none
};

/// Moves the joints of the limb so that its end comes to X_goal as nearly as damping lets it (damped least squares: Buss 2009). A hinge is
/// not led beyond its limit, and not back from where it was beyond it.
/// @param limb links from the limb's base to its end; the end is the last one's frame
/// @param q [nq, in and out]  @param X_WB [links, in and out] poses at q, kept up to date for the links of the limb only
/// @return m, how far the end misses, the orientation's error times the lever included
double reach(const Mechanism& mechanism, std::span<const int> limb, const Pose& X_goal, const ReachOptions& options, double* q,
             std::span<Pose> X_WB);

}  // namespace ugoki
