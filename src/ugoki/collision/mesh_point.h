#pragma once
// A point and a mesh: the nearest point of the surface, and on which side; how deep two closed meshes overlap.

#include <cstdint>
#include <limits>

#include "ugoki/collision/bubble.h"
#include "ugoki/collision/triangle_distance.h"

namespace ugoki::collision {

/// Nearest point of a surface, in the mesh's frame.
struct SurfacePoint {
  std::int32_t triangle = -1;  ///< of the tree; -1: nothing closer than `farthest`, or p is not finite
  TriangleFeature feature = TriangleFeature::face;
  Vec3 q;               ///< m
  double distance = 0;  ///< m, never negative
  bool inside = false;  ///< closed meshes only: p is enclosed
  Vec3 n;               ///< closed meshes only: unit, outwards (where q lies on a side or a corner: the mean of the faces there)
};

/// @param p m, mesh's frame
/// @param warm the triangle of the last query, in and out; -1 at the start
/// @param farthest m: points not closer than this are of no interest
/// Exact up to rounding; the side holds for meshes that do not pierce themselves. No allocation once the workspace has grown.
[[nodiscard]] SurfacePoint find_nearest_point(const SphereTree& mesh, const Vec3& p, std::int32_t& warm, BubbleWorkspace& workspace,
                                              double farthest = std::numeric_limits<double>::infinity());

enum class PenetrationStatus : std::uint8_t {
  apart,        ///< no vertex of either mesh is inside the other (surfaces may still pierce each other, side through face)
  penetrating,  ///< depth > 0
  not_closed,   ///< one of the meshes has no inside
  not_finite,   ///< a pose is not finite or farther away than 1e9 m, or a tree is empty
};

/// The vertex of one mesh that lies deepest inside the other: pa - pb = -depth * n.
struct MeshPenetration {
  PenetrationStatus status = PenetrationStatus::not_finite;
  double depth = 0;  ///< m
  Vec3 pa, pb;       ///< m, world: the vertex, and the point of the other's surface that is nearest to it
  Vec3 n;            ///< unit, world: from b towards a. Moving a by n * depth brings that vertex to the surface
  int points = 0;    ///< how many points were looked at
};

/// What it is, and what it is not: the depth of the deepest VERTEX, exact. It is the depth that a contact needs at this moment; it is
/// not the shortest translation that separates the meshes, which can be longer (hooks, several regions that overlap) or which edges
/// that pass through faces can ask for where no vertex is inside. For meshes whose triangles are small against the depth the
/// difference is small.
/// Branch and bound over spheres: no point of a sphere is deeper than its centre plus its radius.
[[nodiscard]] MeshPenetration find_penetration(const SphereTree& a, const Pose& X_WA, const SphereTree& b, const Pose& X_WB,
                                               BubbleWorkspace& workspace);

}  // namespace ugoki::collision
