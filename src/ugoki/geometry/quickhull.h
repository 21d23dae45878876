#pragma once
// The hull of points in space by Qhull.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "ugoki/spatial/vec3.h"

namespace ugoki::geometry {

/// Polygons over the caller's points.
struct PolygonHull {
  std::vector<std::int32_t> first_corner, corners;  ///< indices into the points; either sense of rotation
  bool too_many = false;                            ///< stopped: more vertices than allowed
};

/// @param points measure about 1 in every direction
/// @param triangles facets that are one plane up to rounding are left as triangles
/// Nothing where Qhull gives up. Its own messages are dropped.
[[nodiscard]] std::optional<PolygonHull> quickhull(std::span<const Vec3> points, std::size_t most_vertices, bool triangles);

}  // namespace ugoki::geometry
