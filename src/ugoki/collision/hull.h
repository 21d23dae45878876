#pragma once
// Convex hulls as they run: flat arrays, made once, never changed.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/spatial/vec3.h"

namespace ugoki::collision {

/// What find_support reads. Derived from the hull's vertices and neighbours.
struct HullWalk {
  /// A vertex and up to eight of its neighbours, four cache lines. Where it has fewer, it stands in for them itself.
  struct alignas(64) Node {
    double x[8], y[8], z[8];  ///< m
    std::int32_t vertex[8];   ///< their indices
    double own[3];            ///< m
    std::int32_t more;        ///< index into `overflow`
    std::int32_t more_count;  ///< how many neighbours beyond eight
  };
  std::vector<Node> nodes;             ///< [vertices]
  std::vector<Node> scan;              ///< of hulls so small that all vertices are looked at: as few as hold all as neighbours
  std::vector<std::int32_t> overflow;  ///< neighbours beyond eight
  std::vector<std::int32_t> seeds;     ///< [6 cells^2] vertex that is extreme along the middle of each cell of a cube of directions
  std::int32_t cells = 0;              ///< cells along an edge of the cube
};

/// Convex hull of a set of points: a solid, or flat (dimension 2), a segment (1) or a point (0).
/// `vertices`, `first_corner`, `corners` say it all (assemble_hull makes the rest of them); those are the arrays to store.
struct Hull {
  int dimension = 0;
  std::vector<Vec3> vertices;  ///< m, shape's frame; neighbours tend to lie close together in the array

  /// Faces as polygons, corners counter-clockwise seen from outside: corners[first_corner[f]] ... corners[first_corner[f + 1] - 1].
  /// A flat hull has two faces (both sides), a segment or point none.
  std::vector<std::int32_t> first_corner, corners;  ///< [faces + 1], [sum of corners]
  std::vector<Vec3> normals;                        ///< [faces] unit, outward
  std::vector<double> offsets;                      ///< [faces] m: normals[f] . x = offsets[f] on the face

  /// Proximity list: the vertices that an edge joins to vertex v are neighbours[first_neighbour[v]] ...
  /// neighbours[first_neighbour[v + 1] - 1].
  std::vector<std::int32_t> first_neighbour, neighbours;  ///< [vertices + 1], [2 edges]

  Vec3 centre;             ///< m: centre of volume (flat: of area, segment: its middle)
  double radius = 0;       ///< m: of the sphere about `centre` that holds all vertices
  double volume = 0;       ///< m^3
  std::uint64_t hash = 0;  ///< of vertices and faces: equal hulls have equal hashes
  HullWalk walk;

  [[nodiscard]] int faces() const { return static_cast<int>(normals.size()); }
  [[nodiscard]] std::span<const std::int32_t> face(int f) const {
    const auto i = static_cast<std::size_t>(f);
    return {corners.data() + first_corner[i], corners.data() + first_corner[i + 1]};
  }
  [[nodiscard]] std::span<const std::int32_t> neighbours_of(int vertex) const {
    const auto i = static_cast<std::size_t>(vertex);
    return {neighbours.data() + first_neighbour[i], neighbours.data() + first_neighbour[i + 1]};
  }
};

/// A hull from its vertices and faces, in this order (make_hull of the module `geometry` finds both from any points).
/// No faces: one vertex is a point, two a segment; two opposite faces a flat hull.
/// An Error where an index or number is out of range, the faces do not close, or it is not convex (by more than 1e-9 of its size).
/// O(vertices log vertices).
[[nodiscard]] Result<Hull> assemble_hull(std::vector<Vec3> vertices, std::vector<std::int32_t> first_corner,
                                         std::vector<std::int32_t> corners);

/// Vertex with the greatest d . x: a walk along edges from `start`, uphill, to where no neighbour is higher.
/// A hull without `walk` is scanned. O(steps * neighbours), no allocation.
/// @param start a vertex; a close one makes it quick
[[nodiscard]] std::int32_t find_extreme_vertex(const Hull& hull, const Vec3& d, std::int32_t start);

/// A vertex close to the extreme one along d, from the table of seeds; 0 where there is none. O(1).
[[nodiscard]] std::int32_t seed_vertex(const Hull& hull, const Vec3& d);

}  // namespace ugoki::collision
