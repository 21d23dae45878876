#pragma once
// Hierarchical spheres over the triangles of a mesh, with an oriented box in each, flat, for exact distances (bubble.h).
// Source: Quinlan, Efficient distance computation between non-convex objects (1994): spheres with centres on the surface;
// Gottschalk, Lin, Manocha, OBBTree (1996): boxes along the principal axes of the surface.

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/collision/bound_block.h"
#include "ugoki/mechanism/geometry.h"
#include "ugoki/spatial/vec3.h"

namespace ugoki::collision {

/// Immutable once made; shared by all bodies that have the mesh.
struct SphereTree {
  Vec3 centre;          ///< m, mesh's frame: the origin of everything below
  double radius = 0;    ///< m: of the sphere about `centre` that holds the mesh
  bool closed = false;  ///< every side of a triangle is shared by exactly one other, the other way round: there is an inside

  std::vector<BoundBlock> blocks;           ///< [0] has one lane, the root; parents before children
  std::vector<Vec3> vertices;               ///< about `centre`, in the order in which the triangles need them
  std::vector<Triangle> triangles;          ///< neighbours in space are neighbours here; the longest side first
  std::vector<std::int32_t> source;         ///< [triangles] index of the triangle in the mesh it was made from
  std::vector<std::int32_t> vertex_source;  ///< [vertices] index of the vertex in that mesh

  /// Closed meshes only: the normals that tell inside from outside where the nearest point lies on a side or a corner.
  /// Source: Baerentzen, Aanaes, Signed distance computation using the angle weighted pseudonormal (2005).
  std::vector<Vec3> vertex_normals;                 ///< [vertices] unit
  std::vector<std::array<std::int32_t, 3>> across;  ///< [triangles] the triangle at the other side of side k (k to k + 1)

  [[nodiscard]] bool empty() const { return triangles.empty(); }
  [[nodiscard]] Vec3 corner(std::int32_t triangle, int k) const {
    return vertices[static_cast<std::size_t>(triangles[static_cast<std::size_t>(triangle)][static_cast<std::size_t>(k)])];
  }
};

/// Same tree on every machine. O(n log n) time, no more than 600 bytes a triangle at any moment. Triangles without area are
/// taken as they are; Geometry has none.
/// Errors (at `place`): no triangle, more than most_triangles, an index out of range, a number not finite or beyond 1e6 m.
[[nodiscard]] Result<SphereTree> make_sphere_tree(std::span<const Vec3> vertices, std::span<const Triangle> triangles,
                                                  std::string_view place = "mesh");

/// What `ugoki info` tells of a tree.
struct SphereTreeReport {
  std::size_t spheres = 0, triangles = 0, bytes = 0;
  std::vector<std::size_t> spheres_at;  ///< [depth] the root has depth 0
  std::vector<double> mean_radius;      ///< [depth] m
  /// [depth] of two spheres with the same parent: how far they reach into each other, as a part of the smaller diameter
  /// (0: apart, 1: one is inside the other); the mean over all such pairs.
  std::vector<double> mean_overlap;
};
[[nodiscard]] SphereTreeReport report_of(const SphereTree& tree);

/// The tree as bytes (little-endian, versioned, with a checksum), to be kept with the mesh's hash.
[[nodiscard]] std::vector<std::uint8_t> write_bytes(const SphereTree& tree);
/// Errors (at `place`): other bytes than write_bytes() gave; whatever they are, what it returns is safe to search.
[[nodiscard]] Result<SphereTree> read_sphere_tree(std::span<const std::uint8_t> bytes, std::string_view place = "sphere tree");

}  // namespace ugoki::collision
