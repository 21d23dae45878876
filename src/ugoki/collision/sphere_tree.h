#pragma once
// Sphere tree: a hierarchy of spheres over the triangles of a mesh, each with an oriented box, in flat arrays. Used for exact
// distances (bubble.h).
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

/// Sphere tree of one mesh. Immutable after make_sphere_tree(); shared by all bodies that have the mesh.
struct SphereTree {
  Vec3 centre;        ///< m, mesh's frame: the origin to which blocks and vertices refer
  double radius = 0;  ///< m: radius of the sphere about `centre` that contains the mesh
  /// True: every side of a triangle is shared with exactly one other triangle, in the opposite direction, so that the mesh has an inside.
  bool closed = false;

  std::vector<BoundBlock> blocks;           ///< block 0 has one lane, the root; parents are before their children
  std::vector<Vec3> vertices;               ///< m, relative to `centre`, in the order in which the triangles first use them
  std::vector<Triangle> triangles;          ///< triangles close in space are close in this list; the longest side is side 0
  std::vector<std::int32_t> source;         ///< [triangles] index of the triangle in the mesh from which the tree was made
  std::vector<std::int32_t> vertex_source;  ///< [vertices] index of the vertex in that mesh

  /// Closed meshes only: pseudonormals, which separate inside from outside if the nearest surface point is on a side or a corner.
  /// Source: Baerentzen, Aanaes, Signed distance computation using the angle weighted pseudonormal (2005).
  std::vector<Vec3> vertex_normals;                 ///< [vertices] unit, outward
  std::vector<std::array<std::int32_t, 3>> across;  ///< [triangles] adjacent triangle at side k (from corner k to k + 1)

  [[nodiscard]] bool empty() const { return triangles.empty(); }
  /// Position of corner k of a triangle, m, relative to `centre`.
  [[nodiscard]] Vec3 corner(std::int32_t triangle, int k) const {
    return vertices[static_cast<std::size_t>(triangles[static_cast<std::size_t>(triangle)][static_cast<std::size_t>(k)])];
  }
};

/// Builds the sphere tree of a mesh (m, mesh's frame). The tree is the same on every machine. O(n log n) time, at most 600 bytes of
/// memory for each triangle. Triangles without area are accepted.
/// Errors (at `location`): no triangle; more than max_triangles; an index out of range; a coordinate not finite or beyond 1e6 m.
[[nodiscard]] Result<SphereTree> make_sphere_tree(std::span<const Vec3> vertices, std::span<const Triangle> triangles,
                                                  std::string_view location = "mesh");

/// Statistics of a sphere tree, printed by `ugoki info`.
struct SphereTreeReport {
  std::size_t spheres = 0, triangles = 0, bytes = 0;  ///< counts, and memory of the arrays
  std::vector<std::size_t> spheres_at;                ///< [depth] count of spheres; the root has depth 0
  std::vector<double> mean_radius;                    ///< [depth] m, mean radius of the spheres
  /// [depth] Overlap of two spheres with the same parent, as a fraction of the smaller diameter (0: apart, 1: one inside the other); mean
  /// over all sibling pairs of that depth.
  std::vector<double> mean_overlap;
};
/// Statistics of a tree. O(spheres)
[[nodiscard]] SphereTreeReport report_of(const SphereTree& tree);

/// Returns the tree as bytes (little-endian, with version and checksum), to be stored with the mesh's hash.
[[nodiscard]] std::vector<std::uint8_t> write_bytes(const SphereTree& tree);
/// Reads the bytes of write_bytes(). A returned tree is safe to search, whatever the bytes were.
/// Errors (at `location`): not a sphere tree; another version; damaged or truncated; inconsistent indices.
[[nodiscard]] Result<SphereTree> read_sphere_tree(std::span<const std::uint8_t> bytes, std::string_view location = "sphere tree");

}  // namespace ugoki::collision
