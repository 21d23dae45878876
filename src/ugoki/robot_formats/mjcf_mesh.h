#pragma once
// Mesh assets of MJCF: convex hull and mass properties by volume integrals. Internal to robot_formats.

#include <array>
#include <span>
#include <vector>

#include "ugoki/spatial/spatial.h"

namespace ugoki::robot_formats {

using MeshTriangle = std::array<int, 3>;  ///< indices into points, counter-clockwise as seen from outside

/// Values of the attribute <mesh inertia="...">, which selects the body that the triangles represent; see mesh_inertia().
enum class MeshInertia { convex, exact, legacy, shell };

/// Returns the triangles of the convex hull of the points; empty if all points are in one plane. O(points * triangles).
[[nodiscard]] std::vector<MeshTriangle> convex_hull(std::span<const Vec3> points);

/// Returns the inertia of the body with respect to the origin of the points, for density 1 kg/m^3 (shell: 1 kg/m^2).
///   convex, exact  the volume enclosed by the triangles, as a sum of signed tetrahedra (for convex, pass the hull's triangles)
///   legacy         all tetrahedra between a triangle and the centre of the surface count as positive, whatever their orientation
///   shell          the surface, without volume
/// Source of the integrals: Tonon, Explicit exact formulas for the 3-D tetrahedron
/// inertia tensor (2005).
[[nodiscard]] Inertia mesh_inertia(std::span<const Vec3> points, std::span<const MeshTriangle> triangles, MeshInertia kind);

}  // namespace ugoki::robot_formats
