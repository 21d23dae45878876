#pragma once
// A monotone map from the phase of one cycle to the phase of another.

#include <vector>

namespace ugoki::motion_edit {

/// A strictly increasing function y(x) with y(x + 1) = y(x) + 1 and continuous slope: cubic Hermite pieces through the given points, with
/// slopes limited so that the curve does not overshoot (Fritsch and Carlson 1980). Phases are in cycles.
class PhaseCurve {
 public:
  struct Point {
    double x = 0, y = 0;
  };
  /// y = x + shift
  explicit PhaseCurve(double shift = 0) : points_{{0, shift}}, slopes_{1} {}
  /// @param points at least one; x and y increase and each spans less than one cycle
  explicit PhaseCurve(std::vector<Point> points);

  [[nodiscard]] double operator()(double x) const;
  /// Returns the x at which the curve has the value y.
  [[nodiscard]] double inverse(double y) const;

 private:
  std::vector<Point> points_;
  std::vector<double> slopes_;
};

}  // namespace ugoki::motion_edit
