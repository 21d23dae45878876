#pragma once
// Status data: the physical properties of one mechanism at one moment. The vectors are sized once from the mechanism.

#include <span>
#include <vector>

#include "ugoki/mechanism/mechanism.h"

namespace ugoki {

struct State {
  std::vector<double> q;       ///< [nq] coordinates, m | rad | unit quaternions
  std::vector<double> v;       ///< [nv] velocities, m/s | rad/s
  std::vector<double> a;       ///< [nv] accelerations, m/s^2 | rad/s^2
  std::vector<double> tau;     ///< [nv] joint forces, N | N m
  std::vector<Vec6> external;  ///< [links] external wrench on each link, about the WORLD origin, in world axes
  double time = 0;             ///< s

  State() = default;
  /// Neutral position, at rest, at time 0.
  explicit State(const Mechanism& m)
      : q(m.neutral()),
        v(static_cast<std::size_t>(m.nv())),
        a(v.size()),
        tau(v.size()),
        external(static_cast<std::size_t>(m.link_count())) {}
};

/// Pose of every link in the world. @param q [nq] @param X_WB [links, out]
void calc_poses(const Mechanism& m, std::span<const double> q, std::span<Pose> X_WB);

/// Velocity of every link in the link's own frame. @param q [nq] @param v [nv] @param V [links, out]
void calc_velocities(const Mechanism& m, std::span<const double> q, std::span<const double> v, std::span<Vec6> V);

/// Computes q_out = q (+) v dt: the configuration after moving for dt [s] at the constant velocity v. q_out may alias q.
void integrate(const Mechanism& m, std::span<const double> q, std::span<const double> v, double dt, std::span<double> q_out);

/// Computes v = q1 (-) q0: the constant velocity that leads from q0 to q1 in 1 s, so that integrate(q0, v, 1) = q1.
void difference(const Mechanism& m, std::span<const double> q0, std::span<const double> q1, std::span<double> v);

/// Interpolates from q0 (s = 0) to q1 (s = 1): linear for scalar coordinates, along a great arc for quaternions.
void interpolate(const Mechanism& m, std::span<const double> q0, std::span<const double> q1, double s, std::span<double> q_out);

/// Centre of mass [m] in the world; zero for a mechanism without mass. @param X_WB [links] from calc_poses
[[nodiscard]] Vec3 centre_of_mass(const Mechanism& m, std::span<const Pose> X_WB);

/// True if all values are finite.
[[nodiscard]] bool is_finite(std::span<const double> values);

}  // namespace ugoki
