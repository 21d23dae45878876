#pragma once
// A reference motion that stands still.

#include <algorithm>
#include <utility>
#include <vector>

#include "ugoki/control/foot_schedule.h"

namespace ugoki::control {

/// A reference that keeps one posture at one place.
class StillMotion final : public ReferenceMotion {
 public:
  /// @param q [nq] posture and place @param end s: duration
  explicit StillMotion(std::vector<double> q, double end = 20) : q_(std::move(q)), end_(end) {}
  void sample(double, std::span<double> q, std::span<double> v, std::span<double> a) const override {
    std::ranges::copy(q_, q.begin());
    std::ranges::fill(v, 0.0);
    std::ranges::fill(a, 0.0);
  }
  [[nodiscard]] double end() const override { return end_; }
  [[nodiscard]] const std::vector<double>& q() const { return q_; }

 private:
  std::vector<double> q_;
  double end_;
};

}  // namespace ugoki::control
