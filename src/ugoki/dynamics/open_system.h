#pragma once
// An open link system under drives, joint forces, gravity and external wrenches, as the integrators see it.

#include <memory>
#include <optional>

#include "ugoki/dynamics/derivatives.h"
#include "ugoki/dynamics/joint_forces.h"
#include "ugoki/dynamics/motion_system.h"

namespace ugoki::dynamics {

struct OpenSystemOptions {
  Vec3 gravity{0, 0, -9.81};  ///< m/s^2
  JointForceOptions joint_forces;
  bool joint_forces_on = true;  ///< springs, dampers, dry friction, limits, effort limits; without them tau is the drive alone
  bool exact_jacobian = false;  ///< gives the implicit methods the derivatives of forward dynamics (memory: 3 nv^2)
};

class OpenSystem : public MotionSystem {
 public:
  explicit OpenSystem(MechanismPtr mechanism, const OpenSystemOptions& options = {});

  std::vector<double> drive;   ///< [nv] N | N m, constant unless calc_drive() says otherwise
  std::vector<Vec6> external;  ///< [links] wrenches about the world origin, world axes

  /// Drive forces at (t, q, v); for control laws. @param tau [nv, out]
  virtual void calc_drive(double t, std::span<const double> q, std::span<const double> v, std::span<double> tau);

  [[nodiscard]] int calc_acceleration(double t, std::span<const double> q, std::span<const double> v, std::span<double> vdot) override;
  [[nodiscard]] bool calc_acceleration_jacobian(double t, std::span<const double> q, std::span<const double> v, std::span<double> dq,
                                                std::span<double> dv) override;

  /// Joint forces of the last call of calc_acceleration().
  [[nodiscard]] const JointForceReport& joint_force_report() const { return report_; }
  /// Kinetic, potential, spring and limit energy [J] of a state.
  [[nodiscard]] double calc_energy(std::span<const double> q, std::span<const double> v);
  [[nodiscard]] Workspace& workspace() { return ws_; }
  [[nodiscard]] const OpenSystemOptions& options() const { return options_; }

 protected:
  /// tau_: drives and joint forces at (t, q, v).
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
