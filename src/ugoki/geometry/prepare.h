#pragma once
// Geometry with everything that collision analysis wants to know beforehand: hulls, proximity lists, sphere trees.

#include <span>
#include <string_view>

#include "ugoki/mechanism/mechanism.h"

namespace ugoki::geometry {

/// The convex hull of the points as a geometry, prepared. An Error (at `place`) where make_hull gives one, and where the points
/// lie in a plane or on a line: such a hull encloses nothing.
[[nodiscard]] Result<GeometryPtr> make_hull_geometry(std::span<const Vec3> points, std::string_view place);

/// The geometry with its hull and sphere tree; itself where it has them. A mesh in a plane has a flat hull.
[[nodiscard]] Result<GeometryPtr> prepare(const GeometryPtr& geometry, std::string_view place);

/// The mechanism with all meshes that collide prepared, each once; itself where there is nothing to do.
[[nodiscard]] Result<MechanismPtr> prepare(const MechanismPtr& mechanism);

}  // namespace ugoki::geometry
