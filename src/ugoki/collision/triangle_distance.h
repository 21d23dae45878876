#pragma once
// Distance of two triangles, exact to rounding, whatever their shape and position.

#include <array>
#include <cstdint>

#include "ugoki/spatial/vec3.h"

namespace ugoki::collision {

using TriangleCorners = std::array<Vec3, 3>;  ///< m

struct TriangleDistance {
  double distance = 0;  ///< m; exactly 0 where the triangles pierce each other
  Vec3 pa, pb;          ///< m: a nearest pair of points
};

/// Error below 1e-14 of the greatest difference of coordinates between the corners, for needles, caps, triangles without area,
/// and parallel and coplanar ones too. NaN in gives NaN out.
/// Source: the nearest points of two triangles that do not meet lie on two sides, or on a corner and a face (Ericson, Real-Time
/// Collision Detection (2005), 5.1.10); parallel sides as in Ericson 5.1.9 with cross products in place of differences of squares.
[[nodiscard]] TriangleDistance triangle_distance(const TriangleCorners& a, const TriangleCorners& b);

/// True where the triangles pierce each other or touch (distance 0 to within 1e-14 of their size).
[[nodiscard]] bool triangles_meet(const TriangleCorners& a, const TriangleCorners& b);

enum class TriangleFeature : std::uint8_t { face, side_0, side_1, side_2, corner_0, corner_1, corner_2 };

/// A point of a triangle, and what it lies on: its inside, side k (from corner k to k + 1), or corner k.
struct TrianglePoint {
  Vec3 p;  ///< m
  TriangleFeature feature = TriangleFeature::face;
};

/// The point of triangle t nearest to p.
[[nodiscard]] TrianglePoint nearest_on_triangle(const TriangleCorners& t, const Vec3& p);

}  // namespace ugoki::collision
