#pragma once
// Interface between the integrators (integrators.h) and a system that can compute its acceleration. The configuration of the system is
// that of a mechanism: a point on a manifold, with unit quaternions for rotations.

#include "ugoki/mechanism/mechanism.h"

namespace ugoki::dynamics {

/// Direction in which an event function must cross zero.
enum class EventDirection : unsigned char { falling, rising, both };

/// Result of MotionSystem::project().
enum class Projection : unsigned char {
  kept,    ///< the state was already admissible
  moved,   ///< q or v was corrected
  failed,  ///< no admissible state was found
};

/// A system that an Integrator can step. Derived classes supply at least the acceleration.
class MotionSystem {
 public:
  explicit MotionSystem(MechanismPtr mechanism) : mechanism_(std::move(mechanism)) {}
  virtual ~MotionSystem() = default;
  MotionSystem(const MotionSystem&) = delete;
  MotionSystem& operator=(const MotionSystem&) = delete;

  [[nodiscard]] const Mechanism& mechanism() const { return *mechanism_; }

  /// Computes the acceleration vdot(t, q, v). An integration step allocates nothing only if this function allocates nothing.
  /// @param t s @param q [nq] m | rad @param v [nv] m/s | rad/s @param vdot [nv, out] m/s^2 | rad/s^2
  /// @return -1 on success, otherwise the DOF whose acceleration is undefined (singular inertia)
  [[nodiscard]] virtual int calc_acceleration(double t, std::span<const double> q, std::span<const double> v, std::span<double> vdot) = 0;

  /// Derivatives d vdot / dq (on the tangent space) and d vdot / dv at (t, q, v), for the implicit methods. Small errors in the
  /// derivatives slow down Newton's method but do not change its result. @param dq, dv [nv * nv, out] row-major
  /// @return false if the system does not provide derivatives; the integrator then uses finite differences
  [[nodiscard]] virtual bool calc_acceleration_jacobian(double /*t*/, std::span<const double> /*q*/, std::span<const double> /*v*/,
                                                        std::span<double> /*dq*/, std::span<double> /*dv*/) {
    return false;
  }

  /// Moves the state at the end of a step to an admissible state: one with closed loops, and velocities that keep them closed.
  [[nodiscard]] virtual Projection project(double /*t*/, std::span<double> /*q*/, std::span<double> /*v*/) { return Projection::kept; }

  /// Number of event functions g(t, q, v). An event is a sign change of its function in the direction event_direction().
  [[nodiscard]] virtual int event_count() const { return 0; }
  [[nodiscard]] virtual EventDirection event_direction(int /*event*/) const { return EventDirection::both; }
  /// Evaluates the event functions. @param g [event_count(), out]
  virtual void calc_events(double /*t*/, std::span<const double> /*q*/, std::span<const double> /*v*/, std::span<double> /*g*/) {}

 private:
  MechanismPtr mechanism_;
};

}  // namespace ugoki::dynamics
