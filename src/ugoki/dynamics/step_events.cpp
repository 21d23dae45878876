#include "ugoki/dynamics/step_events.h"

#include <algorithm>
#include <cmath>

namespace ugoki::dynamics {
namespace {

int first_not_finite(std::span<const double> g) {
  for (std::size_t i = 0; i < g.size(); ++i)
    if (!std::isfinite(g[i])) return static_cast<int>(i);
  return -1;
}

}  // namespace

StepEvents::StepEvents(const MotionSystem& system) {
  const auto count = static_cast<std::size_t>(system.event_count());
  for (std::vector<double>* x : {&g0_, &low_, &high_, &middle_}) x->resize(count);
  pending_.resize(count);
  for (std::size_t e = 0; e < count; ++e) directions_.push_back(system.event_direction(static_cast<int>(e)));
}

int StepEvents::begin(MotionSystem& system, double t, std::span<const double> q, std::span<const double> v) {
  system.calc_events(t, q, v, g0_);
  return first_not_finite(g0_);
}

int StepEvents::calc(MotionSystem& system, Trajectory& path, double s, std::span<double> q, std::span<double> v,
                     std::span<double> g) const {
  path.state_at(s, q, v);
  system.calc_events(path.time_at(s), q, v, g);
  return first_not_finite(g);
}

/// True if the event function crosses zero between the values `before` and `after`, in its direction. A value `before` of exactly zero is
/// no crossing: the event has already been reported, or the motion starts at the zero.
bool StepEvents::crosses(std::size_t event, double before, double after) const {
  const bool falls = before > 0 && after <= 0, rises = before < 0 && after >= 0;
  return (falls && directions_[event] != EventDirection::rising) || (rises && directions_[event] != EventDirection::falling);
}

StepEvents::SearchResult StepEvents::find(MotionSystem& system, Trajectory& path, int samples, double tolerance, std::span<double> q,
                                          std::span<double> v) {
  const std::size_t count = g0_.size();
  const auto any_crossing = [&](std::span<const double> before, std::span<const double> after) {
    for (std::size_t e = 0; e < count; ++e)
      if (crosses(e, before[e], after[e])) return true;
    return false;
  };
  low_ = g0_;
  double low = 0, high = 0;
  bool found = false;
  for (int k = 1; k <= samples && !found; ++k) {
    low = high;
    high = k == samples ? 1.0 : static_cast<double>(k) / samples;
    if (const int bad = calc(system, path, high, q, v, high_); bad >= 0) return {Outcome::not_finite, high, bad};
    found = any_crossing(low_, high_);
    if (!found) std::swap(low_, high_);
  }
  if (!found) return {};
  // Shrink the bracket [low, high] around the first crossing: secant steps for the event with the earliest zero, and bisection in
  // every third iteration so that the bracket always shrinks.
  for (int k = 0; high - low > tolerance && k < 200; ++k) {
    double s = 0.5 * (low + high);
    if (k % 3 != 2) {
      double first = high;
      for (std::size_t e = 0; e < count; ++e)
        if (crosses(e, low_[e], high_[e])) first = std::min(first, low + (high - low) * low_[e] / (low_[e] - high_[e]));
      const double margin = std::min(0.5 * tolerance, 0.25 * (high - low));
      s = std::clamp(first + (k % 3 == 0 ? margin : -margin), low + margin, high - margin);
    }
    if (!(s > low && s < high)) break;
    if (const int bad = calc(system, path, s, q, v, middle_); bad >= 0) return {Outcome::not_finite, s, bad};
    if (any_crossing(low_, middle_)) {
      high = s;
      std::swap(high_, middle_);
    } else {
      low = s;
      std::swap(low_, middle_);
    }
  }
  for (std::size_t e = 0; e < count; ++e) pending_[e] = crosses(e, low_[e], high_[e]);
  return {Outcome::event, high, next_pending()};
}

int StepEvents::next_pending() {
  for (std::size_t e = 0; e < pending_.size(); ++e) {
    if (!pending_[e]) continue;
    pending_[e] = 0;
    return static_cast<int>(e);
  }
  return -1;
}

void StepEvents::clear_pending() {
  for (char& p : pending_) p = 0;
}

}  // namespace ugoki::dynamics
