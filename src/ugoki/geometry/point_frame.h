#pragma once
// The natural axes of a point set: along them it measures about 1 in every direction in which it has any extent.

#include <span>

#include "ugoki/spatial/vec3.h"

namespace ugoki::geometry {

/// Coordinates u = (axes[k] . (p - origin) * scale[k]) lie in about [-1, 1] for k < dimension. Convexity is the same in u as in p.
struct PointFrame {
  int dimension = 0;  ///< 0 all equal, 1 on a line, 2 in a plane, 3
  Vec3 origin;        ///< m
  Vec3 axes[3];       ///< unit, right-handed, not square on each other in general
  double scale[3]{};  ///< 1/m

  [[nodiscard]] Vec3 to_frame(const Vec3& p) const {
    const Vec3 d = p - origin;
    return {dot(axes[0], d) * scale[0], dot(axes[1], d) * scale[1], dot(axes[2], d) * scale[2]};
  }
};

/// An extent counts when it is above what rounding of the coordinates makes (1e-15 of the greatest). O(n).
[[nodiscard]] PointFrame find_frame(std::span<const Vec3> points);

}  // namespace ugoki::geometry
