#pragma once
// Centroidal quantities: momentum and inertia of the whole link system about its centre of mass G, in world axes.
// Call update_kinematics() first.
//
//   h_G = A_G(q) v,   h_G' = A_G vdot + A_G' v = sum of the external wrenches about G, gravity included
//
// Source: Orin, Goswami, Lee, Centroidal dynamics of a humanoid robot (2013). Nothing here allocates. A virtual link has the inertia that
// Workspace::I stores for it. Joint armature is not included.

#include "ugoki/dynamics/workspace.h"

namespace ugoki::dynamics {

/// Mass properties and momentum of the whole link system.
struct Centroidal {
  double mass = 0;  ///< kg
  Vec3 centre;      ///< m, centre of mass, world
  Vec3 velocity;    ///< m/s, velocity of the centre of mass, world
  Vec6 momentum;    ///< about the centre of mass: angular N m s, linear N s
  Sym3 inertia;     ///< kg m^2: inertia of the system with all joints locked, about the centre of mass, world axes
};

/// Centroidal quantities at the state of `ws`. O(links).
[[nodiscard]] Centroidal calc_centroidal(const Mechanism& m, const Workspace& ws);

/// Centroidal momentum matrix A_G. O(links). Overwrites ws.Ic.
/// @param A_G [nv, out] columns: momentum about the centre of mass for unit velocity of each DOF
void calc_centroidal_matrix(const Mechanism& m, Workspace& ws, std::span<Vec6> A_G);

/// Rate of the centroidal momentum [N m, N] at the acceleration `vdot`. An empty `vdot` means zero and gives the bias A_G' v.
/// The linear part divided by the mass is the acceleration of the centre of mass. O(links). Overwrites ws.A. @param vdot [nv] or empty
[[nodiscard]] Vec6 calc_centroidal_momentum_rate(const Mechanism& m, Workspace& ws, std::span<const double> vdot);

/// Gradient of the gravitational potential energy on the tangent space. It equals the joint forces that keep the system at rest.
/// O(links). Overwrites ws.Ic. @param gravity uniform, m/s^2, world @param gradient [nv, out] N | N m
void calc_potential_gradient(const Mechanism& m, Workspace& ws, const Vec3& gravity, std::span<double> gradient);

}  // namespace ugoki::dynamics
