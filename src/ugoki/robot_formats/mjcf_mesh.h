#pragma once
// Mesh assets of MJCF: their points and their mass properties by volume integrals. Internal to robot_formats.

#include <array>
#include <span>
#include <vector>

#include "ugoki/spatial/spatial.h"

namespace ugoki::robot_formats {

using MeshTriangle = std::array<int, 3>;  ///< indices of points, counter-clockwise seen from outside

/// What <mesh inertia="..."> says about which body the triangles bound.
enum class MeshInertia { convex, exact, legacy, shell };

/// Triangles of the convex hull; empty if all points lie in one plane. O(points * triangles).
[[nodiscard]] std::vector<MeshTriangle> convex_hull(std::span<const Vec3> points);

/// Inertia of the body about the points' origin at density 1 kg/m^3 (shell: 1 kg/m^2).
///   convex, exact  the volume that the triangles bound, by signed tetrahedra (give convex the hull's triangles)
///   legacy         every tetrahedron from the centre of the surface counts as positive, whatever its triangle's orientation
///   shell          the surface
/// Source of the integrals over a tetrahedron and a triangle: Tonon, Explicit exact formulas for the 3-D tetrahedron
/// inertia tensor (2005).
[[nodiscard]] Inertia mesh_inertia(std::span<const Vec3> points, std::span<const MeshTriangle> triangles, MeshInertia kind);

}  // namespace ugoki::robot_formats
