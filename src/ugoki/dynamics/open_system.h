#pragma once
// A MotionSystem for an open link system under drives, joint forces, gravity and external wrenches.

#include <memory>
#include <optional>

#include "ugoki/dynamics/derivatives.h"
#include "ugoki/dynamics/joint_forces.h"
#include "ugoki/dynamics/motion_system.h"

namespace ugoki::dynamics {

struct OpenSystemOptions {
  Vec3 gravity{0, 0, -9.81};  ///< m/s^2
  JointForceOptions joint_forces;
  bool joint_forces_on = true;  ///< springs, dampers, dry friction, limits, effort limits; false: tau is the drive force alone
  bool exact_jacobian = false;  ///< analytic derivatives of forward dynamics for the implicit methods (memory: 3 nv^2 doubles)
};

class OpenSystem : public MotionSystem {
 public:
  explicit OpenSystem(MechanismPtr mechanism, const OpenSystemOptions& options = {});

  std::vector<double> drive;   ///< [nv] N | N m: drive forces, used unless a derived class overrides calc_drive()
  std::vector<Vec6> external;  ///< [links] N m, N: external wrenches about the world origin, world axes

  /// Drive forces at (t, q, v). Override it for control laws; by default it returns `drive`. @param tau [nv, out] N | N m
  virtual void calc_drive(double t, std::span<const double> q, std::span<const double> v, std::span<double> tau);

  [[nodiscard]] int calc_acceleration(double t, std::span<const double> q, std::span<const double> v, std::span<double> vdot) override;
  [[nodiscard]] bool calc_acceleration_jacobian(double t, std::span<const double> q, std::span<const double> v, std::span<double> dq,
                                                std::span<double> dv) override;

  /// Report on the joint forces of the last call of calc_acceleration().
  [[nodiscard]] const JointForceReport& joint_force_report() const { return report_; }
  /// Sum of kinetic and potential energy and the energies of springs and limits (JointForceReport) at a state, J.
  [[nodiscard]] double calc_energy(std::span<const double> q, std::span<const double> v);
  [[nodiscard]] Workspace& workspace() { return ws_; }
  [[nodiscard]] const OpenSystemOptions& options() const { return options_; }

 protected:
  /// Computes the sum of drive forces and joint forces at (t, q, v). forces() returns this sum.
  void calc_forces(double t, std::span<const double> q, std::span<const double> v);
  [[nodiscard]] std::span<const double> forces() const { return tau_; }

 private:
  OpenSystemOptions options_;
  Workspace ws_;
  std::vector<double> tau_, slope_q_, slope_v_;
  JointForceReport report_;
  std::optional<ForwardDerivatives> derivatives_;
};

}  // namespace ugoki::dynamics
