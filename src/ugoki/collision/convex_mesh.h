#pragma once
// Exact distance between a convex shape and a mesh: a search of the mesh's sphere tree. Gilbert's method gives the distance of the shape
// from the tree's boxes and, at the leaves, from the triangles.
//
// The convex shape is solid; a mesh means its SURFACE. A shape inside a closed mesh has a positive distance from the mesh's walls.

#include "ugoki/collision/bubble.h"
#include "ugoki/collision/gilbert.h"

namespace ugoki::collision {

/// Warm start of a pair, kept from one query to the next; {} at the first query. Content from another pair makes a query slower but not
/// wrong.
struct ConvexMeshCache {
  std::int32_t triangle = -1;  ///< index of the closest triangle in the tree; -1: none
  GilbertCache gilbert;        ///< warm start of the distance between the shape and that triangle
};

/// Scratch memory of find_distance; one object per thread, for any pairs. Grows with the depth of the trees and is then reused.
class ConvexMeshWorkspace {
 public:
  /// A bound (node of the sphere tree) on the stack of the search.
  struct Entry {
    std::int32_t lane;  ///< index of the bound: block * block_lanes + lane
    double lower;       ///< m: lower bound of the distance of the shape from the triangles in the bound
  };
  std::vector<Entry> stack;
  Hull corners;              ///< the current triangle, as a flat hull
  BubbleWorkspace of_point;  ///< memory of the search for the mesh point closest to a sphere's centre
  ConvexMeshWorkspace();
};

/// Distance between shape a at pose X_WA (bounded: no half-space) and mesh b at pose X_WB. For polytopes the error is at most 1e-12 of the
/// shapes' sizes; for curved shapes it is the duality gap of Gilbert's method (distance - lower). The options are those for two meshes
/// (bubble.h). Status touching: the shape intersects the surface, and the distance is 0. BubbleDistance::nearest.a is always -1.
/// @param cache [in, out] warm start of this pair
[[nodiscard]] BubbleDistance find_distance(const Support& a, const Pose& X_WA, const SphereTree& b, const Pose& X_WB,
                                           ConvexMeshCache& cache, ConvexMeshWorkspace& workspace, const BubbleOptions& options = {});

}  // namespace ugoki::collision
