#pragma once
// A smooth path over the ground through given points. Internal to gait.

#include <span>
#include <vector>

#include "ugoki/spatial/vec3.h"

namespace ugoki::gait {

/// Centripetal Catmull-Rom curve, by arc length. It is straight before its begin and after its end.
class SmoothPath {
 public:
  struct Point {
    double x = 0, y = 0, heading = 0;  ///< m, rad; the heading is continuous
  };
  /// @param points m: two or more different points; z is not used
  explicit SmoothPath(std::span<const Vec3> points);
  [[nodiscard]] double length() const { return 0.02 * static_cast<double>(samples_.size() - 1); }
  /// @param s m: distance along the path
  [[nodiscard]] Point at(double s) const;

 private:
  std::vector<Point> samples_;  // every 2 cm
};

}  // namespace ugoki::gait
