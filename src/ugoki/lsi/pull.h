#pragma once
// Force with which the user pulls a grabbed link: a spring and damper between a point of the link and a target. Spring and damper are
// integrated implicitly, so that the pull is stable on links of any mass.

#include <span>

#include "ugoki/dynamics/dynamics.h"

namespace ugoki::lsi {

struct PullOptions {
  double frequency = 10;     ///< rad/s, undamped natural frequency of the character's total mass on the spring
  double damping = 0.7;      ///< damping ratio of the character's total mass on spring and damper (1: critical)
  double max_weights = 1.5;  ///< maximum force, in body weights of the character at 9.81 m/s^2
};

/// Returns the force [N, world axes] that pulls a point of a link towards a target; zero if the inertia matrix is singular.
///   F = k (target - p') - c u',  p' = p + dt u',  u' = u + dt J M^-1 J^T F
/// where p, u are position and velocity of the point now, p', u' those at the end of the step, J is the Jacobian of the point, M the
/// inertia matrix, k the stiffness and c the damping from `options`.
/// @param ws      working memory of this mechanism; afterwards it contains the kinematics and the factor of M at (q, v)
/// @param p_B     the point in the frame of the link, m
/// @param target  m, world
/// @param dt      s
[[nodiscard]] Vec3 calc_pull(const Mechanism& mechanism, dynamics::Workspace& ws, std::span<const double> q, std::span<const double> v,
                             int link, const Vec3& p_B, const Vec3& target, double dt, const PullOptions& options = {});

}  // namespace ugoki::lsi
