#pragma once
// Collision data that are computed once from a geometry and stored with the geometry.

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

/// Prepared data of one geometry. Files store `hull` and `spheres`; the other members are derived from these two.
struct PreparedGeometry {
  Hull hull;           ///< convex hull with its proximity list; without vertices if it is not known
  SphereTree spheres;  ///< tree over the triangles; empty for convex geometry

  /// The faces around vertex v of the hull are faces[first_face[v]] ... faces[first_face[v + 1] - 1].
  std::vector<std::int32_t> first_face, faces;  ///< [hull vertices + 1], [hull corners]
  /// [triangles of the tree] the adjacent triangle at side k (from corner k to k + 1); -1: none, or more than one
  std::vector<std::array<std::int32_t, 3>> across;
};
using PreparedPtr = std::shared_ptr<const PreparedGeometry>;

/// Makes the prepared data of a geometry.
/// @param hull convex hull; without vertices: not known. If not known, a convex geometry gets the hull formed by its own triangles, a
///   non-convex geometry gets none
/// @param spheres sphere tree; empty: built here, unless the geometry is convex
/// Errors (at `location`): the geometry is marked as convex but is not; `hull` or `spheres` belongs to another geometry; the
/// errors of make_sphere_tree().
[[nodiscard]] Result<PreparedPtr> make_prepared(const Geometry& geometry, Hull hull, SphereTree spheres, std::string_view location);

/// A copy of the geometry that refers to the prepared data.
[[nodiscard]] GeometryPtr with_prepared(const Geometry& geometry, PreparedPtr prepared);

}  // namespace ugoki::collision
