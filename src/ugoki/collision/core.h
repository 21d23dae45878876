#pragma once
// The core of a convex shape: its points deeper than a given depth below its surface. While the core does not touch a surface of triangles,
// the shape has not passed through that surface, however thin the surface is. Internal to collision.

#include <memory>

#include "ugoki/collision/collider.h"

namespace ugoki::collision {

/// Half width [m] of the shape: half the minimum distance between two parallel planes that enclose it. For hulls only planes parallel to a
/// face or to two axes of the shape's frame are considered.
[[nodiscard]] double half_width_of(const Collider& c);

/// Core of a convex shape. All points of the core are at least `depth` below the shape's surface. For ellipsoids and hulls the core may be
/// slightly smaller than the set of all such points.
struct Core {
  Collider collider;
  double depth = 0;            ///< m: depth below the shape's surface
  std::unique_ptr<Hull> hull;  ///< hulls only: the core's hull, to which collider.support points
};
/// Makes the core of `c` with a depth of half_width_of(c) / 2. O(1); hulls: O(vertices * faces).
[[nodiscard]] std::shared_ptr<const Core> make_core(const Collider& c);

}  // namespace ugoki::collision
