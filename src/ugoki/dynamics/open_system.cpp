#include "ugoki/dynamics/open_system.h"

#include <algorithm>

#include "ugoki/dynamics/dynamics.h"

namespace ugoki::dynamics {

OpenSystem::OpenSystem(MechanismPtr mechanism, const OpenSystemOptions& options)
    : MotionSystem(std::move(mechanism)),
      drive(static_cast<std::size_t>(this->mechanism().nv())),
      external(static_cast<std::size_t>(this->mechanism().link_count())),
      options_(options),
      ws_(this->mechanism()),
      tau_(drive.size()) {
  if (!options.exact_jacobian) return;
  slope_q_.resize(drive.size());
  slope_v_.resize(drive.size());
  derivatives_.emplace(this->mechanism(), ws_);
}

void OpenSystem::calc_drive(double /*t*/, std::span<const double> /*q*/, std::span<const double> /*v*/, std::span<double> tau) {
  for (std::size_t i = 0; i < tau.size(); ++i) tau[i] = drive[i];
}

void OpenSystem::calc_forces(double t, std::span<const double> q, std::span<const double> v) {
  calc_drive(t, q, v, tau_);
  if (options_.joint_forces_on) report_ = calc_joint_forces(mechanism(), q, v, tau_, options_.joint_forces, tau_);
}

int OpenSystem::calc_acceleration(double t, std::span<const double> q, std::span<const double> v, std::span<double> vdot) {
  calc_forces(t, q, v);
  if (calc_forward_dynamics(mechanism(), ws_, q, v, tau_, options_.gravity, external, vdot)) return -1;
  calc_inertia_rows(mechanism(), ws_, q);
  return std::max(factor(ws_, {}), 0);
}

bool OpenSystem::calc_acceleration_jacobian(double t, std::span<const double> q, std::span<const double> v, std::span<double> dq,
                                            std::span<double> dv) {
  if (!derivatives_) return false;
  const std::size_t n = tau_.size();
  ForwardDerivatives& d = *derivatives_;
  calc_forces(t, q, v);
  update_kinematics(mechanism(), q, v, ws_);
  if (calc_forward_dynamics_derivatives(mechanism(), ws_, v, tau_, options_.gravity, external, d) >= 0) return false;
  for (std::size_t i = 0; i < n * n; ++i) {
    dq[i] = d.dq[i];
    dv[i] = d.dv[i];
  }
  if (!options_.joint_forces_on) return true;
  calc_joint_force_slopes(mechanism(), q, v, options_.joint_forces, slope_q_, slope_v_);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j) {
      dq[i * n + j] += d.dtau[i * n + j] * slope_q_[j];
      dv[i * n + j] += d.dtau[i * n + j] * slope_v_[j];
    }
  return true;
}

double OpenSystem::calc_energy(std::span<const double> q, std::span<const double> v) {
  update_kinematics(mechanism(), q, v, ws_);
  double energy = kinetic_energy(mechanism(), ws_) + potential_energy(mechanism(), ws_, options_.gravity);
  for (std::size_t i = 0; i < v.size(); ++i) energy += 0.5 * ws_.armature[i] * v[i] * v[i];
  if (options_.joint_forces_on) {
    const JointForceReport report = calc_joint_forces(mechanism(), q, v, {}, options_.joint_forces, tau_);
    energy += report.spring_energy + report.limit_energy;
  }
  return energy;
}

}  // namespace ugoki::dynamics
