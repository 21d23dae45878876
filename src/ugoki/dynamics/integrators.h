#pragma once
// Integration of a MotionSystem in time, on the manifold of its configuration.
//
// Within a step the configuration is written as q0 (+) u, with q0 the step's start. In the coordinates z = (u, v) the motion is an
// ordinary differential equation, u' = T(u) v, v' = a(t, q0 (+) u, v), and every Runge-Kutta method keeps its order (Munthe-Kaas 1999).
// Each step starts a new chart, so no rotation ever comes near the chart's end (|u| = 2 pi).
//
//   method              order  step      use it for
//   semi_implicit_euler 1      fixed     games, contact-like forces: cheapest; energy errs by the step's order and drifts in chaos
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

enum class IntegrationStatus : unsigned char {
  reached,            ///< the time asked for
  event,              ///< stopped just past the event `event`; advance() again goes on
  singular,           ///< the acceleration has no value at `freedom`
  not_finite,         ///< a position, velocity or acceleration came out infinite or NaN at `freedom`, or the event function `event`
  step_too_small,     ///< the tolerance would need a step below min_step
  too_many_steps,     ///< max_steps were taken; advance() again goes on
  not_converged,      ///< the equations of an implicit step were not solved
  projection_failed,  ///< no admissible state near the step's result
};
[[nodiscard]] std::string_view name_of(IntegrationStatus status);

struct IntegratorOptions {
  IntegrationMethod method = IntegrationMethod::dormand_prince_54;
  double step = 0;                                            ///< s: the step; adaptive methods: the first step, 0 = estimated
  bool adaptive = true;                                       ///< false: dormand_prince_54 and radau_iia_5 keep to `step`
  double relative_tolerance = 1e-8;                           ///< of each coordinate and velocity; of 1 rad for rotations
  double absolute_tolerance = 1e-8;                           ///< rad | m, rad/s | m/s
  double min_step = 1e-12;                                    ///< s
  double max_step = std::numeric_limits<double>::infinity();  ///< s
  long max_steps = 100'000'000;                               ///< in one advance()
  double event_tolerance = 1e-10;                             ///< s: events are located to this
  int event_samples = 4;                                      ///< places in a step at which the event functions are looked at
};

/// What ended an advance(). On failure the state is the last good one, `time` its time.
struct IntegrationReport {
  IntegrationStatus status = IntegrationStatus::reached;
  double time = 0;   ///< s
  int freedom = -1;  ///< at fault, or -1
  int link = -1;     ///< whose joint the freedom belongs to
  int event = -1;
};

struct IntegrationStatistics {
  long steps = 0, rejected = 0;
  long accelerations = 0;  ///< evaluations, those for Jacobians and events included
  long jacobians = 0, factorizations = 0;
  long iterations = 0;  ///< of implicit steps
  long events = 0;
};

class Integrator {
 public:
  /// Allocates all that will be needed. `system` must outlive the integrator.
  /// Options out of range are brought into it: steps and tolerances must be positive, a fixed step of 0 means 1 ms.
  Integrator(MotionSystem& system, const IntegratorOptions& options);
  ~Integrator();

  /// Sets the state; steps start afresh (after a collision, a grab, a change of forces). @param q [nq] @param v [nv]
  void start(double t, std::span<const double> q, std::span<const double> v);
  /// Says that the forces have changed, the state not: forgets accelerations that were computed.
  void forget();

  /// Steps until t_end, an event or a failure. t_end at or before time() returns at once. A fixed step is cut at t_end.
  [[nodiscard]] IntegrationReport advance(double t_end);

  [[nodiscard]] double time() const;
  [[nodiscard]] std::span<const double> q() const;
  [[nodiscard]] std::span<const double> v() const;

  /// State at a time of the last step (clamped to it), from its continuous solution: order 4 for dormand_prince_54, 3 for the others, 1 for
  /// semi-implicit Euler. @param q [nq, out] @param v [nv, out]
  void interpolate(double t, std::span<double> q, std::span<double> v) const;

  [[nodiscard]] const IntegrationStatistics& statistics() const;
  /// Step that an adaptive method would take next, s.
  [[nodiscard]] double next_step() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> self_;
};

}  // namespace ugoki::dynamics
