#pragma once
// Convex hull of any set of points.

#include <span>

#include "ugoki/base/result.h"
#include "ugoki/collision/hull.h"

namespace ugoki::geometry {

struct HullOptions {
  /// A hull with more vertices is refused: computing it would take minutes and gigabytes.
  std::size_t max_vertices = 200'000;
};

/// Convex hull of `points` [m]. Equal points are merged. Coplanar points give a flat hull (dimension 2), collinear points a segment
/// (dimension 1). Facets that are coplanar within rounding are merged into one face.
/// Errors: a coordinate that is NaN, infinite or beyond 1e100, fewer than 4 points, more than 500 million points, all points equal,
/// or more hull vertices than `options` allows.
/// O(n log n) for most point sets. Source: Barber, Dobkin, Huhdanpaa, The Quickhull algorithm (1996), as implemented by Qhull.
[[nodiscard]] Result<collision::Hull> make_hull(std::span<const Vec3> points, const HullOptions& options = {});

}  // namespace ugoki::geometry
