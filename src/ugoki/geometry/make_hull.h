#pragma once
// Convex hulls of any set of points.

#include <span>

#include "ugoki/base/result.h"
#include "ugoki/collision/hull.h"

namespace ugoki::geometry {

struct HullOptions {
  /// A hull with more vertices is refused: it would cost minutes and gigabytes.
  std::size_t most_vertices = 200'000;
};

/// Convex hull of `points` [m]. Equal points count once; points in a plane give a flat hull, on a line a segment; facets that are
/// one plane up to rounding are one face.
/// An Error for a number that is NaN or infinite, fewer than 4 points, all points equal, or more vertices than options allow.
/// O(n log n) for most point sets. Source: Barber, Dobkin, Huhdanpaa, The Quickhull algorithm (1996), as implemented by Qhull.
[[nodiscard]] Result<collision::Hull> make_hull(std::span<const Vec3> points, const HullOptions& options = {});

}  // namespace ugoki::geometry
