#pragma once
// What the integrators step: a system whose configuration lives on a mechanism's manifold and whose acceleration is known.

#include "ugoki/mechanism/mechanism.h"

namespace ugoki::dynamics {

enum class EventDirection : unsigned char { falling, rising, both };

enum class Projection : unsigned char {
  kept,    ///< the state was admissible as it is
  moved,   ///< q or v was corrected
  failed,  ///< no admissible state was found
};

class MotionSystem {
 public:
  explicit MotionSystem(MechanismPtr mechanism) : mechanism_(std::move(mechanism)) {}
  virtual ~MotionSystem() = default;
  MotionSystem(const MotionSystem&) = delete;
  MotionSystem& operator=(const MotionSystem&) = delete;

  [[nodiscard]] const Mechanism& mechanism() const { return *mechanism_; }

  /// vdot(t, q, v). Must not allocate if steps shall not. @param vdot [nv, out]
  /// @return -1, or the freedom at which it has no value (a singular inertia)
  [[nodiscard]] virtual int calc_acceleration(double t, std::span<const double> q, std::span<const double> v, std::span<double> vdot) = 0;

  /// d vdot / dq on the tangent space and d vdot / dv at (t, q, v), for the implicit methods. Small errors slow Newton's method down but
  /// do not change its result. @param dq, dv [nv * nv, out] row by row
  /// @return false if the system has none: then finite differences are taken
  [[nodiscard]] virtual bool calc_acceleration_jacobian(double /*t*/, std::span<const double> /*q*/, std::span<const double> /*v*/,
                                                        std::span<double> /*dq*/, std::span<double> /*dv*/) {
    return false;
  }

  /// Brings a state at the end of a step back to what is admissible: loops closed, velocities along them.
  [[nodiscard]] virtual Projection project(double /*t*/, std::span<double> /*q*/, std::span<double> /*v*/) { return Projection::kept; }

  /// Event functions g(t, q, v): an event is a change of sign in its direction.
  [[nodiscard]] virtual int event_count() const { return 0; }
  [[nodiscard]] virtual EventDirection event_direction(int /*event*/) const { return EventDirection::both; }
  /// @param g [event_count, out]
  virtual void calc_events(double /*t*/, std::span<const double> /*q*/, std::span<const double> /*v*/, std::span<double> /*g*/) {}

 private:
  MechanismPtr mechanism_;
};

}  // namespace ugoki::dynamics
