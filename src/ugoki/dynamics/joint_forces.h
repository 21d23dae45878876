#pragma once
// Generalized forces of what a Freedom says besides its inertia: drive, spring, damper, dry friction, limits.
//
//   tau = clamp(drive, effort) - d v - k (x - rest) - f v / sqrt(v^2 + s^2) + limit(x, x')
//
// x is the displacement of joint_displacement(). The components of a spherical joint's rotation vector carry their springs and limits
// through the transposed Jacobian of that vector, so that springs conserve energy there too. Floating joints have neither.
//
// Two things here are smooth stand-ins for what the contact solver (contact/stepper.h) does exactly: dry friction is regularised (a joint
// at rest creeps below the speed s instead of sticking), and limits are penalty springs with losses (Hunt, Crossley 1975):
//   limit = K e max(0, 1 + c e')   with e the depth beyond the limit; its elastic energy is K e^2 / 2.

#include "ugoki/mechanism/mechanism.h"

namespace ugoki::dynamics {

struct JointForceOptions {
  double friction_speed = 1e-2;    ///< s: rad/s | m/s at which dry friction has 0.71 of its greatest value
  double limit_turn = 5e3;         ///< K of angles, N m/rad
  double limit_shift = 2e5;        ///< K of distances, N/m
  double limit_dissipation = 0.5;  ///< c: s/rad | s/m; restitution is about 1 - 2/3 c (speed of impact) for small c times speed
};

struct JointForceReport {
  double spring_energy = 0;  ///< J held by springs
  double limit_energy = 0;   ///< J held by limits that are exceeded
  double loss = 0;           ///< W turned into heat by dampers and dry friction and in limits
  double drive_power = 0;    ///< W given by the drives, after the effort limits
  int limits = 0;            ///< freedoms beyond a limit
  int saturated = 0;         ///< drives that wanted more than their effort
};

/// @param drive [nv] N | N m, or empty for none @param tau [nv, out] may alias drive. O(nv), no allocation.
JointForceReport calc_joint_forces(const Mechanism& m, std::span<const double> q, std::span<const double> v, std::span<const double> drive,
                                   const JointForceOptions& options, std::span<double> tau);

/// Their slopes d tau_i / dq_i and d tau_i / dv_i. Exact for joints other than spherical ones; for those the coupling of the
/// components is left out: good for Newton's method, not for sensitivities. @param dq, dv [nv, out]
void calc_joint_force_slopes(const Mechanism& m, std::span<const double> q, std::span<const double> v, const JointForceOptions& options,
                             std::span<double> dq, std::span<double> dv);

}  // namespace ugoki::dynamics
