#pragma once
// Exact distance of a convex shape and a mesh: Gilbert's method of the shape against bounds, and against triangles at the leaves.
//
// The convex shape is solid, the mesh is its SURFACE: the distance of a shape that a closed mesh encloses is that from its walls.

#include "ugoki/collision/bubble.h"
#include "ugoki/collision/gilbert.h"

namespace ugoki::collision {

/// What a pair remembers from one query to the next; all {} at the start. Wrong or foreign content costs time, never truth.
struct ConvexMeshCache {
  std::int32_t triangle = -1;  ///< of the tree: the nearest
  GilbertCache gilbert;        ///< of the shape and that triangle
};

/// Scratch memory of find_distance; one for each thread, any pair may use it. Grows with the depth of the trees, then stays.
class ConvexMeshWorkspace {
 public:
  struct Entry {
    std::int32_t lane;  ///< block * block_lanes + lane
    double lower;       ///< m: a lower bound of the distance
  };
  std::vector<Entry> stack;
  Hull corners;              ///< of the triangle that is looked at
  BubbleWorkspace of_point;  ///< for spheres
  ConvexMeshWorkspace();
};

/// Distance of shape a (bounded: no half-space) at pose X_WA and mesh b at pose X_WB, poses of their frames. Exact to 1e-12 of the
/// sizes for polytopes, and to that of Gilbert's duality gap for curved shapes; options as for two meshes. nearest.a is always -1.
/// status touching: the shape reaches the surface, distance 0.
[[nodiscard]] BubbleDistance find_distance(const Support& a, const Pose& X_WA, const SphereTree& b, const Pose& X_WB,
                                           ConvexMeshCache& cache, ConvexMeshWorkspace& workspace, const BubbleOptions& options = {});

}  // namespace ugoki::collision
