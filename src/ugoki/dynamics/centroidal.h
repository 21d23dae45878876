#pragma once
// Quantities of the whole link system about its centre of mass G, world axes, after update_kinematics().
//
//   h_G = A_G(q) v,   h_G' = A_G vdot + A_G' v = sum of the external wrenches about G, gravity included
//
// Source: Orin, Goswami, Lee, Centroidal dynamics of a humanoid robot (2013). Nothing here allocates. Virtual links count as they
// stand. A freedom's armature has no part in them.

#include "ugoki/dynamics/workspace.h"

namespace ugoki::dynamics {

struct Centroidal {
  double mass = 0;  ///< kg
  Vec3 centre;      ///< m, world
  Vec3 velocity;    ///< m/s of the centre
  Vec6 momentum;    ///< about the centre: N m s, N s
  Sym3 inertia;     ///< kg m^2 about the centre, all joints held: the composite body
};

/// O(links).
[[nodiscard]] Centroidal calc_centroidal(const Mechanism& m, const Workspace& ws);

/// Centroidal momentum matrix. O(links). @param A_G [nv, out] its columns: momentum about the centre per unit of each freedom's velocity
void calc_centroidal_matrix(const Mechanism& m, Workspace& ws, std::span<Vec6> A_G);

/// Rate of the centroidal momentum [N m, N] under the acceleration `vdot` (empty: zero; then it is the bias A_G' v). Its
/// linear part over the mass is the acceleration of the centre. O(links). @param vdot [nv] or empty
[[nodiscard]] Vec6 calc_centroidal_momentum_rate(const Mechanism& m, Workspace& ws, std::span<const double> vdot);

/// Gradient of the potential energy in a uniform gravity [m/s^2] on the tangent space: the joint forces that hold the
/// system at rest. O(links). @param gradient [nv, out] N | N m
void calc_potential_gradient(const Mechanism& m, Workspace& ws, const Vec3& gravity, std::span<double> gradient);

}  // namespace ugoki::dynamics
