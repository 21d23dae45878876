#pragma once
// A monotone map from one phase of a cycle to another.

#include <vector>

namespace ugoki::motion_edit {

/// y(x) with y(x + 1) = y(x) + 1, strictly rising, continuous with its slope: cubic Hermite pieces through the given points, their slopes
/// limited so that nothing overshoots (Fritsch and Carlson 1980).
class PhaseCurve {
 public:
  struct Point {
    double x = 0, y = 0;
  };
  /// y = x + shift
  explicit PhaseCurve(double shift = 0) : points_{{0, shift}}, slopes_{1} {}
  /// @param points rising in x and in y, within less than one cycle of both; at least one
  explicit PhaseCurve(std::vector<Point> points);

  [[nodiscard]] double operator()(double x) const;
  /// x at which the curve has the value y.
  [[nodiscard]] double inverse(double y) const;

 private:
  std::vector<Point> points_;
  std::vector<double> slopes_;
};

}  // namespace ugoki::motion_edit
