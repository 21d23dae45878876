#pragma once
// True distance between two shapes, for single queries. For repeated queries of the same pair use pair_distance.h, which keeps caches.

#include "ugoki/collision/collider.h"

namespace ugoki::collision {

/// Signed distance [m] between the surfaces of two shapes. Negative: penetration depth, the length of the shortest translation that
/// separates them. Exact up to rounding for spheres, capsules and boxes; the error is at most 1e-9 of the shapes' sizes for other convex
/// shapes. Surfaces of triangles that intersect have distance 0.
/// @param X_WA, X_WB world poses of the LINKS that carry the shapes; each shape's own X_BS is applied here
/// @param pa, pb [out, may be null] m, world: closest (deepest) points on a and b, pa - pb = n * distance
/// @param n [out, may be null] unit, world: normal from b towards a; if symmetry allows several normals, one of them
/// O(1) and no allocation for spheres, capsules and boxes. Otherwise allocates scratch memory, and prepares geometry that is not prepared.
[[nodiscard]] double distance(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB, Vec3* pa = nullptr, Vec3* pb = nullptr,
                              Vec3* n = nullptr);
[[nodiscard]] double distance(const Collider& a, const Pose& X_WA, const Collider& b, const Pose& X_WB, Vec3* pa = nullptr,
                              Vec3* pb = nullptr, Vec3* n = nullptr);

/// Signed distance [m] of a shape from the plane z = height [m]; negative: depth of its lowest point below the plane.
/// @param X_WA world pose of the LINK that carries the shape
/// @param pa [out, may be null] m, world: the lowest point of the shape; not set for height fields and meshes without a hull
[[nodiscard]] double distance_to_ground(const Shape& a, const Pose& X_WA, double height, Vec3* pa = nullptr);

}  // namespace ugoki::collision
