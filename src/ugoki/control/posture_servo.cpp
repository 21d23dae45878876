#include "ugoki/control/posture_servo.h"

#include <algorithm>
#include <cmath>

namespace ugoki::control {

void set_posture_servo(const dynamics::Workspace& ws, const ServoSettings& s, double dt, std::span<const double> v,
                       std::span<const double> error, std::span<const double> gradient, std::span<double> tau, std::span<double> gain,
                       std::span<double> velocity) {
  for (std::size_t i = 0; i < tau.size(); ++i) {
    tau[i] = gain[i] = velocity[i] = 0;
    if (i < 6) continue;
    const Dof& d = ws.dofs[i];
    const double limit = s.strength * d.effort;
    const double inertia = ws.M[static_cast<std::size_t>(ws.row_start[i] + ws.depth[i])];
    const double kp = inertia * s.frequency * s.frequency, kd = 2 * s.damping * inertia * s.frequency;
    tau[i] = std::clamp(s.gravity_share * gradient[i], -limit, limit);
    // The gain is at most the torque limit per 4 rad/s, so that an impact within a step cannot exceed the limit by much.
    gain[i] = std::min(kd + dt * kp, limit / 4);
    if (!(gain[i] > 0)) continue;
    // kp * (error - dt v') - kd v' = gain * (velocity - v')
    const double wanted = kp * error[i] / (kd + dt * kp), room = (limit - std::fabs(tau[i])) / gain[i];
    velocity[i] = std::clamp(wanted, v[i] - room, v[i] + room);
  }
}

}  // namespace ugoki::control
