#pragma once
// Convex hull of points in a plane.

#include <cstdint>
#include <span>
#include <vector>

namespace ugoki::geometry {

struct PlanarPoint {
  double x = 0, y = 0;
  std::int32_t index = 0;  ///< the caller's
};

/// The corners, counter-clockwise, by the caller's indices; points on an edge (within 1e-14) are no corners. O(n log n).
/// Source: Andrew, Another efficient algorithm for convex hulls in two dimensions (1979).
[[nodiscard]] std::vector<std::int32_t> planar_hull(std::vector<PlanarPoint> points);

}  // namespace ugoki::geometry
