#pragma once
// Surfaces that shapes share: meshes of triangles and height fields. Immutable once made.

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

inline constexpr std::size_t most_triangles = 2'000'000;
inline constexpr std::size_t most_heights = 4'000'000;

/// A mesh of triangles in the frame of the shapes that use it.
struct Geometry {
  std::vector<Vec3> vertices;  ///< m; no two are the same
  std::vector<Triangle> triangles;
  bool convex = false;     ///< the triangles are the surface of a convex body, and that body is meant; otherwise the surface itself
  std::uint64_t hash = 0;  ///< of vertices, triangles and `convex`
  Inertia solid;           ///< of what the triangles enclose, at density 1 kg/m^3; mass 0 where they enclose nothing
  std::shared_ptr<const collision::PreparedGeometry> prepared;  ///< what collision analysis precomputed; may be null
};
using GeometryPtr = std::shared_ptr<const Geometry>;

/// What was found, and mended, in the triangles that made a geometry.
struct GeometryFindings {
  std::size_t doubled_vertices = 0;   ///< dropped: another vertex lies at the very same place
  std::size_t unused_vertices = 0;    ///< dropped: no triangle has them as a corner
  std::size_t flat_triangles = 0;     ///< dropped: without area
  std::size_t doubled_triangles = 0;  ///< dropped: the same corners in the same order
  std::size_t open_edges = 0;         ///< sides of a triangle that no other triangle has the other way round: holes, seams
  bool inside_out = false;            ///< closed, but its triangles look inwards
};

/// Welds vertices at the same place, drops triangles without area and vertices without triangle, and computes the rest.
/// Errors (at `place`): no triangle with area, an index out of range, a number not finite or beyond 1e6 m, more than
/// most_triangles; convex: not closed, or no volume. Whether a surface said to be convex is so is not checked.
[[nodiscard]] Result<GeometryPtr> make_geometry(std::span<const Vec3> vertices, std::span<const Triangle> triangles, bool convex,
                                                std::string_view place, GeometryFindings* findings = nullptr);

/// What stands in the way of a geometry as it is (open edges, inside out); the rest is zero. O(triangles log triangles)
[[nodiscard]] GeometryFindings inspect(const Geometry& geometry);

/// Inertia at density 1 kg/m^3 of what a closed surface encloses, about the origin, by the divergence theorem.
[[nodiscard]] Inertia enclosed_inertia(std::span<const Vec3> vertices, std::span<const Triangle> triangles);

/// Ground whose height is given on a grid: solid from the surface down to z = -base. The grid's point (column, row) lies at
/// x = half_x (2 column / (columns - 1) - 1), y likewise with its row; each cell is two triangles that share the diagonal
/// from (column, row) to (column + 1, row + 1).
struct HeightField {
  int columns = 0, rows = 0;       ///< at least 2 each
  double half_x = 0, half_y = 0;   ///< m
  double base = 0;                 ///< m, how far below z = 0 the solid reaches; above minus the least height
  std::vector<double> heights;     ///< [rows * columns] m, row by row
  double lowest = 0, highest = 0;  ///< m, of the heights
  std::uint64_t hash = 0;

  [[nodiscard]] Vec3 point(int column, int row) const {
    return {half_x * (2.0 * column / (columns - 1) - 1), half_y * (2.0 * row / (rows - 1) - 1),
            heights[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column)]};
  }
};
using HeightFieldPtr = std::shared_ptr<const HeightField>;

/// Fills in what follows from the rest. Errors (at `place`): fewer than two rows or columns, a wrong number of heights, a
/// number not finite or beyond 1e6 m, sides that are not above zero, a base that is not below all heights.
[[nodiscard]] Result<HeightFieldPtr> make_height_field(HeightField field, std::string_view place);

}  // namespace ugoki
