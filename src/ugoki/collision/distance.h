#pragma once
// True distance between two primitive shapes.

#include "ugoki/mechanism/shape.h"

namespace ugoki::collision {

/// Signed distance [m] between the surfaces: positive apart, negative the depth of penetration (the shortest translation
/// that separates them). Exact up to rounding for every pair of sphere, capsule and box.
/// @param X_WA, X_WB poses of the LINKS that carry the shapes; each shape's own X_BS is applied to it
/// @param pa, pb [out, may be null] m, world: a nearest (deepest) pair of points on a and b, pa - pb = n * distance
/// @param n [out, may be null] unit, world: from b towards a. Where symmetry leaves several, one of them.
/// O(1), no allocation.
[[nodiscard]] double distance(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB, Vec3* pa = nullptr, Vec3* pb = nullptr,
                              Vec3* n = nullptr);

/// The same to the ground's plane z = height.
[[nodiscard]] double distance_to_ground(const Shape& a, const Pose& X_WA, double height, Vec3* pa = nullptr);

/// Radius [m] of the sphere about the shape's centre that holds it.
[[nodiscard]] double bounding_radius(const Shape& shape);

}  // namespace ugoki::collision
