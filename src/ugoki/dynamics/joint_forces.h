#pragma once
// Generalized joint forces: drive, spring, damper, dry friction and limits of each DOF.
//
//   tau = clamp(drive, effort) - d v - k (x - rest) - f v / sqrt(v^2 + s^2) + limit(x, x')
//
// d, k, rest, f and effort are the damping, stiffness, rest, friction and effort of the DOF. x is its displacement (joint_displacement()).
// For spherical joints x is the rotation vector. Forces on the components of x are converted to joint torques by the transposed Jacobian of
// the rotation vector (rotation_chart.h), so that springs conserve energy. Floating joints have no springs and no limits.
//
// Dry friction and limits are smooth approximations of what the contact solver (contact/stepper.h) computes exactly:
// - Dry friction is regularised: a loaded joint creeps slowly instead of sticking.
// - Limits are penalty springs with dissipation (Hunt, Crossley 1975): limit = K e max(0, 1 + c e'), where e is the depth beyond the limit.
//   The elastic energy is K e^2 / 2.

#include "ugoki/mechanism/mechanism.h"

namespace ugoki::dynamics {

struct JointForceOptions {
  double friction_speed = 1e-2;    ///< symbol s: speed at which dry friction is 0.71 of its maximum, rad/s | m/s
  double limit_turn = 5e3;         ///< stiffness K of limits on angles, N m/rad
  double limit_shift = 2e5;        ///< stiffness K of limits on distances, N/m
  double limit_dissipation = 0.5;  ///< symbol c, s/rad | s/m: restitution is about 1 - 2/3 c * impact speed, where it is near 1
};

/// Energies and powers of the joint forces at one state.
struct JointForceReport {
  double spring_energy = 0;  ///< J: energy stored in springs
  double limit_energy = 0;   ///< J: energy stored in exceeded limits
  double loss = 0;           ///< W: power dissipated by dampers, dry friction and limits
  double drive_power = 0;    ///< W: power delivered by the drives, after the effort limits
  int limits = 0;            ///< number of DOFs beyond a limit
  int saturated = 0;         ///< number of drives clamped to their effort
};

/// Computes the joint forces tau. O(nv), no allocation.
/// @param drive [nv] N | N m, or empty for none @param tau [nv, out] may alias `drive`
JointForceReport calc_joint_forces(const Mechanism& m, std::span<const double> q, std::span<const double> v, std::span<const double> drive,
                                   const JointForceOptions& options, std::span<double> tau);

/// Diagonal derivatives d tau_i / dq_i and d tau_i / dv_i of the joint forces. Exact except for spherical joints, where the coupling of
/// the components is ignored: sufficient for Newton's method, not for sensitivity analysis. @param dq, dv [nv, out]
void calc_joint_force_slopes(const Mechanism& m, std::span<const double> q, std::span<const double> v, const JointForceOptions& options,
                             std::span<double> dq, std::span<double> dv);

}  // namespace ugoki::dynamics
