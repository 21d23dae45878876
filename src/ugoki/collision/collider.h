#pragma once
// A shape prepared for collision analysis.

#include <memory>

#include "ugoki/collision/prepared_geometry.h"
#include "ugoki/collision/support.h"
#include "ugoki/mechanism/shape.h"

namespace ugoki::collision {

struct Core;

/// A shape with its bounds and support function. Built once by make_collider(), then constant.
struct Collider {
  Shape shape;
  bool convex = true;    ///< true: `support` defines the shape; false: triangles define it (non-convex mesh, height field)
  Support support;       ///< support function of the shape; for a non-convex mesh that of its convex hull, if the hull was prepared
  PreparedPtr prepared;  ///< meshes only: hull and sphere tree; owns the hull that `support` points to
  Vec3 centre;           ///< m, shape's frame: centre of the bounding sphere
  double bound = 0;      ///< m: radius of the bounding sphere
  double reach = 0;      ///< m: upper bound of the distance of the shape's points from the origin of its frame
  Vec3 half;             ///< m: half extents of the bounding box about `centre`, along the shape's axes
  double thickness = 0;  ///< m: minimum component of `half`
  std::shared_ptr<const Core> core;  ///< set for convex shapes in scenes with non-convex shapes (core.h), else null
};

/// Makes the collider of a shape. Uses the prepared data of a mesh's geometry; missing data are prepared here, except for the hull of a
/// mesh that is not convex. A mesh that is declared convex but is not is used as a surface of triangles. O(vertices) if the mesh is
/// prepared, O(triangles log triangles) otherwise.
[[nodiscard]] Collider make_collider(const Shape& shape);

}  // namespace ugoki::collision
