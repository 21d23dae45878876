#pragma once
// Principal axes and scales of a point set. In these coordinates the extent of the set is about 1 along every axis with a nonzero extent.

#include <span>

#include "ugoki/spatial/vec3.h"

namespace ugoki::geometry {

/// Affine coordinates u[k] = axes[k] . (p - origin) * scale[k], within about [-1, 1] for k < dimension. An affine map preserves
/// convexity, so the hull can be computed in u.
struct PointFrame {
  int dimension = 0;  ///< 0: all points equal, 1: on a line, 2: in a plane, 3: in space
  Vec3 origin;        ///< m
  Vec3 axes[3];       ///< unit, orthogonal, right-handed
  double scale[3]{};  ///< 1/m

  [[nodiscard]] Vec3 to_frame(const Vec3& p) const {
    const Vec3 d = p - origin;
    return {dot(axes[0], d) * scale[0], dot(axes[1], d) * scale[1], dot(axes[2], d) * scale[2]};
  }
};

/// Finds the frame of `points`. An extent counts as nonzero above about 1.6e-15 of the largest coordinate, the rounding error of the
/// coordinates. O(n).
[[nodiscard]] PointFrame find_frame(std::span<const Vec3> points);

}  // namespace ugoki::geometry
