#pragma once
// Inside the integrators: events of a step, located on its continuous solution.

#include <vector>

#include "ugoki/dynamics/motion_system.h"

namespace ugoki::dynamics {

class StepEvents {
 public:
  explicit StepEvents(const MotionSystem& system);

  /// State of a step at s in [0, 1], written into q and v.
  class Path {
   public:
    virtual ~Path() = default;
    virtual void state_at(double s, std::span<double> q, std::span<double> v) = 0;
    [[nodiscard]] virtual double time_at(double s) const = 0;
  };

  enum class Found : unsigned char { none, event, not_finite };
  struct Answer {
    Found found = Found::none;
    double s = 1;    ///< just past the event
    int event = -1;  ///< which
  };

  [[nodiscard]] bool none() const { return g0_.empty(); }
  /// Takes the values at a state from which a step will start. @return the event function that is not finite, or -1
  [[nodiscard]] int begin(MotionSystem& system, double t, std::span<const double> q, std::span<const double> v);
  /// Looks for the first event of a step. Events that fall together with it are kept for next_pending().
  /// @param tolerance in s @param q, v scratch
  [[nodiscard]] Answer find(MotionSystem& system, Path& path, int samples, double tolerance, std::span<double> q, std::span<double> v);
  /// An event at the time of the one found that was not reported yet, or -1.
  [[nodiscard]] int next_pending();
  void forget_pending();

 private:
  [[nodiscard]] int calc(MotionSystem& system, Path& path, double s, std::span<double> q, std::span<double> v, std::span<double> g) const;
  [[nodiscard]] bool crosses(std::size_t event, double before, double after) const;

  std::vector<double> g0_, low_, high_, middle_;  // [events]
  std::vector<EventDirection> directions_;
  std::vector<char> pending_;
};

}  // namespace ugoki::dynamics
