#pragma once
// Location of events within one step, on the step's continuous solution. Internal to the integrators.

#include <vector>

#include "ugoki/dynamics/motion_system.h"

namespace ugoki::dynamics {

/// Finds the first sign change of a system's event functions within a step.
class StepEvents {
 public:
  explicit StepEvents(const MotionSystem& system);

  /// The continuous solution of a step, as a function of s in [0, 1] from the start to the end of the step.
  class Trajectory {
   public:
    virtual ~Trajectory() = default;
    /// Writes the state at the fraction s of the step into q [nq] and v [nv].
    virtual void state_at(double s, std::span<double> q, std::span<double> v) = 0;
    /// Returns the simulation time in seconds at the fraction s of the step.
    [[nodiscard]] virtual double time_at(double s) const = 0;
  };

  enum class Outcome : unsigned char { none, event, not_finite };
  /// Result of find().
  struct SearchResult {
    Outcome outcome = Outcome::none;
    double s = 1;    ///< fraction of the step, 0 to 1: just after the event, or where an event function is not finite
    int event = -1;  ///< index of the event function; -1: none
  };

  /// True if the system has no event functions.
  [[nodiscard]] bool none() const { return g0_.empty(); }
  /// Evaluates the event functions at the start of a step. @return index of an event function that is not finite, or -1
  [[nodiscard]] int begin(MotionSystem& system, double t, std::span<const double> q, std::span<const double> v);
  /// Finds the first event of a step. Other events at the same time are kept for next_pending().
  /// @param samples number of equal intervals of the step; signs are compared between the ends of each interval
  /// @param tolerance accuracy of SearchResult::s, a fraction of the step @param q, v [nq], [nv] scratch
  [[nodiscard]] SearchResult find(MotionSystem& system, Trajectory& path, int samples, double tolerance, std::span<double> q,
                                  std::span<double> v);
  /// Returns the next unreported event at the time of the last event found, and marks it as reported; -1: none.
  [[nodiscard]] int next_pending();
  void clear_pending();

 private:
  [[nodiscard]] int calc(MotionSystem& system, Trajectory& path, double s, std::span<double> q, std::span<double> v,
                         std::span<double> g) const;
  [[nodiscard]] bool crosses(std::size_t event, double before, double after) const;

  std::vector<double> g0_, low_, high_, middle_;  // [events] event functions; step start; low, high, inner point of the search
  std::vector<EventDirection> directions_;
  std::vector<char> pending_;
};

}  // namespace ugoki::dynamics
