#pragma once
// What collision analysis computes from a geometry once, to be stored with it.

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "ugoki/collision/hull.h"
#include "ugoki/collision/sphere_tree.h"
#include "ugoki/mechanism/geometry.h"

namespace ugoki::collision {

/// `hull` and `spheres` are stored; the rest follows from them.
struct PreparedGeometry {
  Hull hull;           ///< convex hull with its proximity list; without vertices where it is not known
  SphereTree spheres;  ///< empty for convex geometry

  /// The faces around each vertex of the hull: faces[first_face[v]] ... faces[first_face[v + 1] - 1].
  std::vector<std::int32_t> first_face, faces;  ///< [hull vertices + 1], [hull corners]
  /// [triangles of the tree] the triangle beyond side k (from corner k to k + 1), or -1
  std::vector<std::array<std::int32_t, 3>> across;
};
using PreparedPtr = std::shared_ptr<const PreparedGeometry>;

/// From a hull (without vertices: none is known; convex geometry gets the one that its triangles are) and a tree (empty: made
/// here, unless the geometry is convex).
/// Errors (at `place`): the geometry is said to be convex and is not; hull or tree belong to another geometry.
[[nodiscard]] Result<PreparedPtr> make_prepared(const Geometry& geometry, Hull hull, SphereTree spheres, std::string_view place);

/// The same geometry with what was prepared for it.
[[nodiscard]] GeometryPtr with_prepared(const Geometry& geometry, PreparedPtr prepared);

}  // namespace ugoki::collision
