#pragma once
// Posture servo: implicit springs and dampers that move the joints to a posture, within the drives' torque limits.

#include <span>
#include <vector>

#include "ugoki/dynamics/dynamics.h"

namespace ugoki::control {

/// Stiffness of the servo.
struct ServoSettings {
  double frequency = 7;      ///< rad/s: natural frequency of each joint's error, with the inertia of everything that the joint moves
  double damping = 1;        ///< fraction of critical damping
  double gravity_share = 0;  ///< share of the weight of the moved parts that the drives hold, 0 ... 1
  double strength = 1;       ///< share of the drives' torque limits that the servo may use
};

/// Drives that act as the servo. The stepper applies gain * (velocity - v') with the velocity v' at the end of the step, so that the servo
/// is stable at any stiffness.
/// @param ws results of update_kinematics() and calc_inertia_rows() @param error [nv] wanted minus present position
/// @param gradient [nv] torques that hold the weight (calc_potential_gradient) @param tau, gain, velocity [nv, out]
void set_posture_servo(const dynamics::Workspace& ws, const ServoSettings& settings, double dt, std::span<const double> v,
                       std::span<const double> error, std::span<const double> gradient, std::span<double> tau, std::span<double> gain,
                       std::span<double> velocity);

}  // namespace ugoki::control
