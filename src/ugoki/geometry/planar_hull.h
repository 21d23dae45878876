#pragma once
// Convex hull of points in a plane.

#include <cstdint>
#include <span>
#include <vector>

namespace ugoki::geometry {

struct PlanarPoint {
  double x = 0, y = 0;
  std::int32_t index = 0;  ///< identifier chosen by the caller
};

/// Indices (PlanarPoint::index) of the hull's corners, counter-clockwise. Points on an edge are not corners: three points count as
/// collinear if twice the area of their triangle is at most 1e-14. This limit fits coordinates of about 1. O(n log n).
/// Source: Andrew, Another efficient algorithm for convex hulls in two dimensions (1979).
[[nodiscard]] std::vector<std::int32_t> planar_hull(std::vector<PlanarPoint> points);

}  // namespace ugoki::geometry
