#pragma once
// The core of a convex shape: what of it lies deeper than a given depth. While the core of a body does not touch a surface, the body has
// not come through it, however thin the surface is. Internal to collision.

#include <memory>

#include "ugoki/collision/collider.h"

namespace ugoki::collision {

/// m: half of the least distance of two parallel planes that hold the shape; of a hull, of those along its faces.
[[nodiscard]] double half_width_of(const Collider& c);

/// A convex shape within another, at least `depth` from its surface (of an ellipsoid and a hull, perhaps a little more).
struct Core {
  Collider collider;
  double depth = 0;            ///< m
  std::unique_ptr<Hull> hull;  ///< of a hull: what the support points at
};
/// Half as deep as half_width_of(c). Hulls: O(vertices faces)
[[nodiscard]] std::shared_ptr<const Core> make_core(const Collider& c);

}  // namespace ugoki::collision
