#pragma once
// Time integration of a MotionSystem on its configuration manifold.
//
// Within a step the configuration is q0 (+) u, where q0 is the configuration at the step's start. In the coordinates z = (u, v) the motion
// is an ordinary differential equation, u' = T(u) v, v' = a(t, q0 (+) u, v), and every Runge-Kutta method keeps its order (Munthe-Kaas
// 1999). Each step starts a new chart (coordinates u), so a rotation within a step stays far from the chart's singularity at |u| = 2 pi.
//
//   method              order  step      use it for
//   semi_implicit_euler 1      fixed     games, forces like those of contacts; cheapest; energy error of order 1, drifts if chaotic
//   runge_kutta_4       4      fixed     smooth motion in real time
//   dormand_prince_54   5      adaptive  accurate results, events
//   gauss_legendre_6    6      fixed     long conservative runs: symmetric, energy does not drift
//   radau_iia_5         5      adaptive  stiff systems: hard springs, heavy dampers
//
// Sources: Hairer, Norsett, Wanner, Solving ordinary differential equations I (1993), II.4-II.6; Hairer, Wanner, II (1996), IV.8; Dormand,
// Prince (1980); Hairer, Lubich, Wanner, Geometric numerical integration (2006).

#include <limits>
#include <memory>

#include "ugoki/dynamics/motion_system.h"

namespace ugoki::dynamics {

enum class IntegrationMethod : unsigned char { semi_implicit_euler, runge_kutta_4, dormand_prince_54, gauss_legendre_6, radau_iia_5 };

/// Why advance() returned.
enum class IntegrationStatus : unsigned char {
  reached,            ///< t_end was reached
  event,              ///< stopped just after the event `event`; call advance() again to continue
  singular,           ///< the acceleration is not defined because `dof` moves no inertia
  not_finite,         ///< a position, velocity or acceleration of `dof`, or the event function `event`, is infinite or NaN
  step_too_small,     ///< the tolerance requires a step below min_step
  too_many_steps,     ///< max_steps were taken; call advance() again to continue
  not_converged,      ///< the iteration of an implicit step did not converge
  projection_failed,  ///< MotionSystem::project() found no admissible state near the step's result
};
/// Status as text, for example "step too small".
[[nodiscard]] std::string_view name_of(IntegrationStatus status);

struct IntegratorOptions {
  IntegrationMethod method = IntegrationMethod::dormand_prince_54;
  double step = 0;                                            ///< s: step size; adaptive methods: first step, 0 = estimated
  bool adaptive = true;                                       ///< false: dormand_prince_54 and radau_iia_5 use the fixed `step`
  double relative_tolerance = 1e-8;                           ///< relative to each coordinate and velocity; for rotations relative to 1 rad
  double absolute_tolerance = 1e-8;                           ///< of coordinates, rad | m, and velocities, rad/s | m/s
  double min_step = 1e-12;                                    ///< s
  double max_step = std::numeric_limits<double>::infinity();  ///< s
  long max_steps = 100'000'000;                               ///< limit for one advance()
  double event_tolerance = 1e-10;                             ///< s: accuracy of event times
  int event_samples = 4;                                      ///< number of times in a step at which event functions are evaluated
};

/// Result of advance(). After a failure the integrator's state is the last valid one, and `time` is its time.
struct IntegrationReport {
  IntegrationStatus status = IntegrationStatus::reached;
  double time = 0;  ///< s
  int dof = -1;     ///< velocity index of the DOF that caused the failure, or -1
  int link = -1;    ///< index of the link whose joint has `dof`, or -1
  int event = -1;   ///< index of the event or event function, or -1
};

/// Counts since the integrator was constructed.
struct IntegrationStatistics {
  long steps = 0, rejected = 0;
  long accelerations = 0;  ///< number of evaluations, including those for Jacobians and events
  long jacobians = 0, factorizations = 0;
  long iterations = 0;  ///< iterations of implicit steps
  long events = 0;
};

class Integrator {
 public:
  /// Allocates all memory. `system` must outlive the integrator. Invalid options are replaced by valid ones: steps and tolerances must be
  /// positive; a fixed step of 0 becomes 1 ms.
  Integrator(MotionSystem& system, const IntegratorOptions& options);
  ~Integrator();

  /// Sets the state and discards all results of earlier steps. Call it after a discontinuity such as a collision or a grab.
  /// @param t s @param q [nq] @param v [nv]
  void start(double t, std::span<const double> q, std::span<const double> v);
  /// Discards cached accelerations. Call it if the forces have changed but the state has not.
  void forget();

  /// Steps until t_end, an event or a failure. Returns at once if t_end is not after time(). A fixed step is shortened at t_end.
  [[nodiscard]] IntegrationReport advance(double t_end);

  [[nodiscard]] double time() const;
  [[nodiscard]] std::span<const double> q() const;
  [[nodiscard]] std::span<const double> v() const;

  /// State at a time within the last step, from the step's continuous solution. `t` is clamped to the step. Order 4 for dormand_prince_54,
  /// 1 for semi_implicit_euler, 3 for the others. @param q [nq, out] @param v [nv, out]
  void interpolate(double t, std::span<double> q, std::span<double> v) const;

  [[nodiscard]] const IntegrationStatistics& statistics() const;
  /// Next step size of an adaptive method, s.
  [[nodiscard]] double next_step() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> self_;
};

}  // namespace ugoki::dynamics
