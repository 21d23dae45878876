#pragma once
// The hand that grabs a link: a spring and damper between a point of the link and a target, taken implicitly, so that it is
// stable on a finger as well as on a trunk.

#include <span>

#include "ugoki/dynamics/dynamics.h"

namespace ugoki::lsi {

struct PullOptions {
  double frequency = 10;      ///< rad/s of the whole figure's mass on the spring
  double damping = 0.7;       ///< share of critical damping of that
  double most_weights = 1.5;  ///< greatest force, in weights of the figure at 9.81 m/s^2
};

/// Force [N], world axes, on the point p_B of `link` towards `target`.
/// F = k (target - p') - c u' with the point's velocity u' = u + dt J M^-1 J^T F at the end of the step.
/// @param ws scratch of this mechanism; its kinematics and factor are of (q, v) afterwards
[[nodiscard]] Vec3 calc_pull(const Mechanism& mechanism, dynamics::Workspace& ws, std::span<const double> q, std::span<const double> v,
                             int link, const Vec3& p_B, const Vec3& target, double dt, const PullOptions& options = {});

}  // namespace ugoki::lsi
