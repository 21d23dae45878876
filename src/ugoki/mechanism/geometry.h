#pragma once
// Surface data that several shapes can share: triangle meshes and height fields. Immutable once made.

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/spatial/spatial.h"

namespace ugoki {

namespace collision {
struct PreparedGeometry;  // collision/prepared_geometry.h
}

using Triangle = std::array<std::int32_t, 3>;  ///< indices of vertices, counter-clockwise seen from outside

inline constexpr std::size_t max_triangles = 2'000'000;  ///< meshes with more triangles are refused
inline constexpr std::size_t max_heights = 4'000'000;    ///< height fields with more heights are refused

/// A triangle mesh, in the frame of the shapes that use it.
struct Geometry {
  std::vector<Vec3> vertices;  ///< m; all different
  std::vector<Triangle> triangles;
  bool convex = false;     ///< true: a solid convex body with these triangles as its surface; false: a surface without interior
  std::uint64_t hash = 0;  ///< hash of vertices, triangles and `convex`
  Inertia solid;           ///< inertia of the enclosed volume at density 1 kg/m^3; mass 0 if the surface is open or inside out
  std::shared_ptr<const collision::PreparedGeometry> prepared;  ///< data precomputed for collision analysis; may be null
};
using GeometryPtr = std::shared_ptr<const Geometry>;

/// Defects of the input triangles of make_geometry(). The first four were repaired, the last two were not.
struct GeometryFindings {
  std::size_t doubled_vertices = 0;   ///< merged: another vertex has exactly the same coordinates
  std::size_t unused_vertices = 0;    ///< removed: no triangle uses them
  std::size_t flat_triangles = 0;     ///< removed: their area is zero within rounding
  std::size_t doubled_triangles = 0;  ///< removed: another triangle has the same corners in the same cyclic order
  std::size_t open_edges = 0;         ///< triangle sides that no other triangle uses in the opposite direction, at holes and seams
  bool inside_out = false;            ///< the surface is closed, but its normals point inwards
};

/// Makes a geometry: merges equal vertices, removes triangles without area and unused vertices, and computes hash and inertia. Errors (at
/// `location`): no triangle has an area, an index is out of range, a coordinate is not finite or beyond 1e6 m, more than max_triangles
/// triangles. If `convex`, also: the surface is open or encloses no volume. Convexity itself is not checked.
/// @param findings [out] defects found; may be null
/// O(triangles log triangles)
[[nodiscard]] Result<GeometryPtr> make_geometry(std::span<const Vec3> vertices, std::span<const Triangle> triangles, bool convex,
                                                std::string_view location, GeometryFindings* findings = nullptr);

/// Returns the defects that a finished geometry can still have: open edges, inside out. The other fields are zero.
/// O(triangles log triangles)
[[nodiscard]] GeometryFindings inspect(const Geometry& geometry);

/// Inertia about the origin of the volume inside a closed surface, at density 1 kg/m^3, by the divergence theorem.
/// The mass is negative if the normals point inwards. O(triangles)
[[nodiscard]] Inertia enclosed_inertia(std::span<const Vec3> vertices, std::span<const Triangle> triangles);

/// Ground with its heights on a regular grid, solid from the surface down to z = -base. Grid point (column, row) is at
/// x = half_x (2 column / (columns - 1) - 1), y = half_y (2 row / (rows - 1) - 1). Each cell is split into two triangles along
/// the diagonal from (column, row) to (column + 1, row + 1).
struct HeightField {
  int columns = 0, rows = 0;       ///< at least 2 each
  double half_x = 0, half_y = 0;   ///< m, half extents along x and y
  double base = 0;                 ///< m, depth of the solid's bottom below z = 0; must be above -lowest
  std::vector<double> heights;     ///< [rows * columns] m, row by row
  double lowest = 0, highest = 0;  ///< m, minimum and maximum of `heights`
  std::uint64_t hash = 0;

  [[nodiscard]] Vec3 point(int column, int row) const {
    return {half_x * (2.0 * column / (columns - 1) - 1), half_y * (2.0 * row / (rows - 1) - 1),
            heights[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column)]};
  }
};
using HeightFieldPtr = std::shared_ptr<const HeightField>;

/// Checks the field and computes lowest, highest and hash. Errors (at `location`): fewer than two rows or columns, a wrong number
/// of heights, a value that is not finite or beyond 1e6 m, a half_x or half_y that is not above zero, a bottom that is not below
/// all heights. O(heights)
[[nodiscard]] Result<HeightFieldPtr> make_height_field(HeightField field, std::string_view location);

}  // namespace ugoki
