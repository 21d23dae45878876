#pragma once
// True distance of two shapes, for those who ask once (pair_distance.h is for those who ask in every step).

#include "ugoki/collision/collider.h"

namespace ugoki::collision {

/// Signed distance [m] between the surfaces: positive apart, negative the depth of penetration (the shortest translation
/// that separates them). Exact up to rounding for every pair of sphere, capsule and box, to 1e-9 of the sizes for other convex
/// shapes; between surfaces of triangles 0 where they pierce each other.
/// @param X_WA, X_WB poses of the LINKS that carry the shapes; each shape's own X_BS is applied to it
/// @param pa, pb [out, may be null] m, world: a nearest (deepest) pair of points on a and b, pa - pb = n * distance
/// @param n [out, may be null] unit, world: from b towards a. Where symmetry leaves several, one of them.
/// O(1) and no allocation for sphere, capsule and box; otherwise scratch memory is made, and geometry prepared where it is not.
[[nodiscard]] double distance(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB, Vec3* pa = nullptr, Vec3* pb = nullptr,
                              Vec3* n = nullptr);
[[nodiscard]] double distance(const Collider& a, const Pose& X_WA, const Collider& b, const Pose& X_WB, Vec3* pa = nullptr,
                              Vec3* pb = nullptr, Vec3* n = nullptr);

/// The same to the ground's plane z = height. A height field has no point.
[[nodiscard]] double distance_to_ground(const Shape& a, const Pose& X_WA, double height, Vec3* pa = nullptr);

}  // namespace ugoki::collision
