#pragma once
// Precomputes the data of meshes that collision analysis needs: hulls, proximity lists, sphere trees.

#include <span>
#include <string_view>

#include "ugoki/mechanism/mechanism.h"

namespace ugoki::geometry {

/// Returns the convex hull of the points [m] as a prepared geometry. Errors (at `location`): the errors of make_hull(); all
/// points are in a plane or on a line, so that the hull encloses no volume.
[[nodiscard]] Result<GeometryPtr> make_hull_geometry(std::span<const Vec3> points, std::string_view location);

/// Returns the geometry with its hull and, unless convex, its sphere tree; returns the same pointer if the geometry already has both. A
/// mesh in a plane gets a flat hull.
[[nodiscard]] Result<GeometryPtr> prepare(const GeometryPtr& geometry, std::string_view location);

/// Returns the mechanism with all colliding meshes prepared; returns the same pointer if no mesh needs preparation. Equal meshes are
/// prepared once. Errors: the problems of all meshes, located at their links.
[[nodiscard]] Result<MechanismPtr> prepare(const MechanismPtr& mechanism);

}  // namespace ugoki::geometry
