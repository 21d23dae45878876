#pragma once
// Distance between two triangles, exact up to rounding for all shapes and positions.

#include <array>
#include <cstdint>

#include "ugoki/spatial/vec3.h"

namespace ugoki::collision {

using TriangleCorners = std::array<Vec3, 3>;  ///< m

/// Distance between two triangles a and b.
struct TriangleDistance {
  double distance = 0;  ///< m; exactly 0 if the triangles pierce each other
  Vec3 pa, pb;          ///< m: closest points on a and b
};

/// Distance and closest points of two triangles. The error is below 1e-14 of the maximum difference of coordinates between the corners,
/// also for needles, caps (an angle near 180 degrees), triangles without area, and parallel or coplanar triangles. NaN or infinite
/// coordinates give NaN. Source: the closest points of two disjoint triangles are on two sides, or on a corner and a face (Ericson,
/// Real-Time Collision Detection (2005), 5.1.10); sides as in Ericson 5.1.9, with cross products instead of differences of squares.
[[nodiscard]] TriangleDistance triangle_distance(const TriangleCorners& a, const TriangleCorners& b);

/// True if the triangles pierce each other or touch (their distance is at most 1e-14 of their size).
[[nodiscard]] bool triangles_meet(const TriangleCorners& a, const TriangleCorners& b);

/// Feature of a triangle: its interior, side k (from corner k to k + 1), or corner k.
enum class TriangleFeature : std::uint8_t { face, side_0, side_1, side_2, corner_0, corner_1, corner_2 };

/// A point of a triangle, and the feature of the triangle that contains the point.
struct TrianglePoint {
  Vec3 p;  ///< m
  TriangleFeature feature = TriangleFeature::face;
};

/// The point of triangle t nearest to p [m].
[[nodiscard]] TrianglePoint nearest_on_triangle(const TriangleCorners& t, const Vec3& p);

}  // namespace ugoki::collision
