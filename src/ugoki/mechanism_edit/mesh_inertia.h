#pragma once
// Mass properties of a body whose surface is given.

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/mechanism/geometry.h"

namespace ugoki {

struct MeshInertiaOptions {
  double density = 1000;  ///< kg/m^3
  double mass = 0;        ///< kg; above 0: the density that gives this mass
};

struct MeshInertia {
  Inertia inertia;         ///< in the mesh's frame
  double density = 0;      ///< kg/m^3
  double volume = 0;       ///< m^3
  double area = 0;         ///< m^2
  std::size_t parts = 0;   ///< closed surfaces of which none touches another
  std::size_t turned = 0;  ///< triangles that looked the other way than their neighbours, or inwards, and were turned
  std::vector<std::string> report;
};

/// By the divergence theorem (Mirtich 1996; Eberly 2002): exact for the polyhedron but for rounding. Triangles that look against their
/// neighbours are turned to the side of most; a part that looks inwards is turned too, unless it lies within another: then it is a cavity
/// and is subtracted. Both are told, and so is a part that lies within another and looks outwards (its mass counts twice).
/// Errors: holes (their number, where they are and how wide), a surface with one side only, no volume, and those of make_geometry.
/// O(triangles log triangles + parts * triangles)
[[nodiscard]] Result<MeshInertia> mesh_inertia(std::span<const Vec3> vertices, std::span<const Triangle> triangles, std::string_view place,
                                               const MeshInertiaOptions& options = {});

}  // namespace ugoki
