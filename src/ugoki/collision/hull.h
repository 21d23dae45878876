#pragma once
// Convex hulls for collision queries: flat arrays, built once, then constant.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/spatial/vec3.h"

namespace ugoki::collision {

/// Data for hill climbing on a hull (find_support). Derived from the hull's vertices and neighbours.
struct HullWalk {
  /// A vertex and up to eight of its neighbours, in four cache lines. Missing neighbours are filled with the vertex itself.
  struct alignas(64) Node {
    double x[8], y[8], z[8];  ///< m: coordinates of the neighbours
    std::int32_t vertex[8];   ///< indices of the neighbours
    double own[3];            ///< m: coordinates of the vertex
    std::int32_t more;        ///< index into `overflow` of the ninth neighbour
    std::int32_t more_count;  ///< count of neighbours beyond eight
  };
  std::vector<Node> nodes;             ///< [vertices] one node for each vertex of the hull
  std::vector<Node> scan;              ///< hulls of at most 16 vertices: one or two nodes that list all vertices; else empty
  std::vector<std::int32_t> overflow;  ///< vertex indices: neighbours of each vertex after the eighth
  std::vector<std::int32_t> seeds;  ///< [6 * cells^2] extreme vertex along the central direction of each cell of a cube map of directions
  std::int32_t cells = 0;           ///< count of cells along an edge of the cube map; 0: no seeds
};

/// Convex hull of a set of points: a solid (dimension 3), flat (2), a segment (1) or a point (0).
/// Files store only `vertices`, `first_corner` and `corners`; assemble_hull derives the rest from them.
struct Hull {
  int dimension = 0;
  std::vector<Vec3> vertices;  ///< m, shape's frame; the order keeps neighbours close together in memory

  /// Faces as polygons. Face f has the vertices corners[first_corner[f]] ... corners[first_corner[f + 1] - 1], counter-clockwise seen from
  /// outside.
  /// A flat hull has two faces (one per side), a segment or a point has none.
  std::vector<std::int32_t> first_corner, corners;  ///< [faces + 1], [sum of corners]
  std::vector<Vec3> normals;                        ///< [faces] unit, outward
  std::vector<double> offsets;                      ///< [faces] m: normals[f] . x = offsets[f] on the face

  /// Proximity list: the neighbours of vertex v along edges are neighbours[first_neighbour[v]] ...
  /// neighbours[first_neighbour[v + 1] - 1].
  std::vector<std::int32_t> first_neighbour, neighbours;  ///< [vertices + 1], [2 * edges]

  Vec3 centre;             ///< m: centroid of the volume (flat: of the area; segment: midpoint)
  double radius = 0;       ///< m: radius of the sphere about `centre` that contains all vertices
  double volume = 0;       ///< m^3
  std::uint64_t hash = 0;  ///< hash of vertices and faces: equal hulls have equal hashes
  HullWalk walk;

  /// Count of faces.
  [[nodiscard]] int faces() const { return static_cast<int>(normals.size()); }
  /// Indices of the vertices of face f.
  [[nodiscard]] std::span<const std::int32_t> face(int f) const {
    const auto i = static_cast<std::size_t>(f);
    return {corners.data() + first_corner[i], corners.data() + first_corner[i + 1]};
  }
  [[nodiscard]] std::span<const std::int32_t> neighbours_of(int vertex) const {
    const auto i = static_cast<std::size_t>(vertex);
    return {neighbours.data() + first_neighbour[i], neighbours.data() + first_neighbour[i + 1]};
  }
};

/// Builds a hull from its vertices and faces, and keeps their order. To build a hull from arbitrary points, use geometry::make_hull.
/// Without faces: one vertex makes a point, two a segment. Two opposite faces make a flat hull.
/// Error: an index or coordinate is out of range, the faces do not form a closed surface, or the surface is not convex (tolerance: 1e-9 of
/// the radius). O(vertices log vertices).
[[nodiscard]] Result<Hull> assemble_hull(std::vector<Vec3> vertices, std::vector<std::int32_t> first_corner,
                                         std::vector<std::int32_t> corners);

/// Index of the vertex with the maximum d . x, found by hill climbing along edges from `start`. For a hull without `walk` all vertices are
/// tested.
/// O(steps * neighbours), no allocation.
/// @param start index of a vertex; a vertex close to the result makes the search fast
[[nodiscard]] std::int32_t find_extreme_vertex(const Hull& hull, const Vec3& d, std::int32_t start);

/// Index of a vertex close to the extreme vertex along d, from the table HullWalk::seeds; 0 if the hull has no table. O(1).
[[nodiscard]] std::int32_t seed_vertex(const Hull& hull, const Vec3& d);

}  // namespace ugoki::collision
