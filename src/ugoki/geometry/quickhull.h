#pragma once
// Convex hull of points in space, computed by Qhull.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "ugoki/spatial/vec3.h"

namespace ugoki::geometry {

/// Faces of a hull as polygons: indices into the caller's points.
struct PolygonHull {
  std::vector<std::int32_t> first_corner, corners;  ///< [faces + 1]; corners of each face, clockwise or counter-clockwise
  bool too_many = false;                            ///< true: stopped, because the hull has more vertices than allowed
};

/// Computes the hull of `points`, which must have an extent of about 1 in every direction. Returns nullopt if Qhull fails; its
/// messages are discarded.
/// @param triangles true: output triangles only; false: merge facets that are coplanar within rounding into polygons
[[nodiscard]] std::optional<PolygonHull> quickhull(std::span<const Vec3> points, std::size_t max_vertices, bool triangles);

}  // namespace ugoki::geometry
