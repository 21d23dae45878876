#pragma once
// Mass properties of a solid body from its surface mesh.

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
  double mass = 0;        ///< kg; if above 0, `density` is ignored and the density follows from this mass
};

struct MeshInertia {
  Inertia inertia;                  ///< in the mesh's frame
  double density = 0;               ///< kg/m^3
  double volume = 0;                ///< m^3
  double area = 0;                  ///< m^2
  std::size_t parts = 0;            ///< number of connected closed surfaces
  std::size_t turned = 0;           ///< number of triangles whose orientation was reversed
  std::vector<std::string> report;  ///< sentences for the user about repairs
};

/// Computes mass properties by the divergence theorem (Mirtich 1996; Eberly 2002), exact for the polyhedron except for rounding.
/// Orientation is repaired: triangles that disagree with their neighbours are reversed towards the majority. A connected part with inward
/// normals is a cavity and is subtracted if it is inside another part; otherwise it is reversed. The report names these repairs, and parts
/// with outward normals inside another part: the mass of such a part is counted twice.
/// Errors: holes (number, position and width of the widest), a one-sided surface, no volume, and those of make_geometry.
/// O(triangles log triangles + parts * triangles)
[[nodiscard]] Result<MeshInertia> mesh_inertia(std::span<const Vec3> vertices, std::span<const Triangle> triangles,
                                               std::string_view location, const MeshInertiaOptions& options = {});

}  // namespace ugoki
