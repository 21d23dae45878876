#pragma once
// Queries of meshes: the surface point nearest to a given point, with a flag whether the given point is inside; and the penetration
// depth of two closed meshes.

#include <cstdint>
#include <limits>

#include "ugoki/collision/bubble.h"
#include "ugoki/collision/triangle_distance.h"

namespace ugoki::collision {

/// Result of find_nearest_point(): nearest point of a surface, in the mesh's frame.
struct SurfacePoint {
  std::int32_t triangle = -1;  ///< index into SphereTree::triangles; -1: no point closer than `farthest`, or p is not finite
  TriangleFeature feature = TriangleFeature::face;  ///< face, side or corner of the triangle on which q is
  Vec3 q;                                           ///< m: nearest point of the surface
  double distance = 0;                              ///< m, from the given point to q; never negative
  bool inside = false;                              ///< closed meshes only: the given point is inside the mesh
  Vec3 n;  ///< closed meshes only: unit outward normal at q; on a side or corner the pseudonormal (mean over the adjacent faces)
};

/// Nearest point of the mesh surface to p. Exact up to rounding; `inside` is correct for meshes without self-intersections.
/// No allocation once the workspace has grown.
/// @param p m, mesh's frame
/// @param warm [in, out] triangle of the previous query, which starts the search; -1 at the first query
/// @param farthest m: search radius; points at this distance or farther are ignored
[[nodiscard]] SurfacePoint find_nearest_point(const SphereTree& mesh, const Vec3& p, std::int32_t& warm, BubbleWorkspace& workspace,
                                              double farthest = std::numeric_limits<double>::infinity());

enum class PenetrationStatus : std::uint8_t {
  apart,        ///< no vertex of either mesh is inside the other (a side of one may still pierce a face of the other)
  penetrating,  ///< depth > 0
  not_closed,   ///< one of the meshes is open, so that it has no inside
  not_finite,   ///< a pose is not finite or farther away than 1e9 m, or a tree is empty
};

/// Result of find_penetration(): the vertex of one mesh that is deepest inside the other. pa - pb = -depth * n.
struct MeshPenetration {
  PenetrationStatus status = PenetrationStatus::not_finite;
  double depth = 0;  ///< m
  Vec3 pa, pb;       ///< m, world: pa on mesh a, pb on mesh b; one is the vertex, the other the nearest surface point of the other mesh
  Vec3 n;            ///< unit, world: from b towards a. Moving a by n * depth brings the vertex to the surface
  int points = 0;    ///< count of nearest-point queries, for tuning
};

/// Depth of the deepest VERTEX of two closed meshes inside each other, exact up to rounding.
/// This depth is suitable for a contact at one moment. The shortest translation that separates the meshes can be longer (hooks, several
/// overlapping regions). The shortest translation is also non-zero if only edges pierce faces and no vertex is inside. The difference
/// between the two is small if the triangles are small compared with the depth.
/// Method: branch and bound over the spheres of the sphere tree. No point of a sphere is deeper than the depth of its centre plus its
/// radius.
[[nodiscard]] MeshPenetration find_penetration(const SphereTree& a, const Pose& X_WA, const SphereTree& b, const Pose& X_WB,
                                               BubbleWorkspace& workspace);

}  // namespace ugoki::collision
