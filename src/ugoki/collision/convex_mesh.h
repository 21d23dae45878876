#pragma once
// Exact distance of a convex shape and a mesh: a search of the mesh's sphere tree. Gilbert's method gives the distance of the shape from
// the bounds and, at the leaves, from the triangles.
//
// The convex shape is solid; a mesh means its SURFACE. A shape inside a closed mesh has a positive distance from the mesh's walls.

#include "ugoki/collision/bubble.h"
#include "ugoki/collision/gilbert.h"

namespace ugoki::collision {

/// Warm start of a pair, kept from one query to the next; {} at the first query. Content from another pair makes a query slower but not
/// wrong.
struct ConvexMeshCache {
  std::int32_t triangle = -1;  ///< index of the closest triangle in the tree; -1: none
  GilbertCache gilbert;        ///< warm start of the shape and that triangle
};

/// Scratch memory of find_distance; one object per thread, for any pairs. Grows with the depth of the trees and is then reused.
class ConvexMeshWorkspace {
 public:
  /// A bound on the stack of the search.
  struct Entry {
    std::int32_t lane;  ///< block * block_lanes + lane
    double lower;       ///< m: a lower bound of the distance
  };
  std::vector<Entry> stack;
  Hull corners;              ///< the current triangle, as a flat hull
  BubbleWorkspace of_point;  ///< search for the point of the mesh closest to a sphere's centre
  ConvexMeshWorkspace();
};

/// Distance of shape a (bounded: no half-space) at pose X_WA and mesh b at pose X_WB. The error is at most 1e-12 of the sizes for
/// polytopes; for curved shapes it is the duality gap of Gilbert's method (distance - lower). Options as for two meshes. Status touching:
/// the shape intersects the surface, distance 0. nearest.a of the result is always -1.
/// @param cache [in, out] warm start of this pair
[[nodiscard]] BubbleDistance find_distance(const Support& a, const Pose& X_WA, const SphereTree& b, const Pose& X_WB,
                                           ConvexMeshCache& cache, ConvexMeshWorkspace& workspace, const BubbleOptions& options = {});

}  // namespace ugoki::collision
