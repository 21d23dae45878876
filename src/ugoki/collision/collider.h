#pragma once
// A shape as collision analysis sees it, prepared once.

#include <memory>

#include "ugoki/collision/prepared_geometry.h"
#include "ugoki/collision/support.h"
#include "ugoki/mechanism/shape.h"

namespace ugoki::collision {

struct Core;

struct Collider {
  Shape shape;
  bool convex = true;                ///< `support` says what it is; otherwise its triangles do (mesh that is not convex, height field)
  Support support;                   ///< of the shape; of a mesh that is not convex: of its convex hull, if that is known
  PreparedPtr prepared;              ///< mesh; keeps what `support` points at alive
  Vec3 centre;                       ///< m, shape's frame: of the sphere that holds it
  double bound = 0;                  ///< m: its radius
  double reach = 0;                  ///< m: no point is farther from the shape's origin
  Vec3 half;                         ///< m: half extents of the box about `centre`, along the shape's axes, that holds it
  double thickness = 0;              ///< m: the least of them
  std::shared_ptr<const Core> core;  ///< of convex shapes in scenes with surfaces of triangles; else null
};

/// Uses what a mesh's geometry has prepared; what is missing is prepared here (all but the hull of a mesh that is not convex). A
/// mesh that cannot be prepared (said to be convex, and is not) is taken as its surface.
/// O(1) for what is prepared, O(triangles log triangles) otherwise.
[[nodiscard]] Collider make_collider(const Shape& shape);

}  // namespace ugoki::collision
