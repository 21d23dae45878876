#pragma once
// Contact points of two convex shapes. The normal at the closest (deepest) points selects a face or edge of each shape. The two selected
// features are clipped against each other.

#include <vector>

#include "ugoki/collision/collider.h"
#include "ugoki/collision/manifold.h"
#include "ugoki/collision/penetration.h"

namespace ugoki::collision {

/// Adds up to 4 contact points of the convex shapes a and b with distances below `margin` [m] to `out`. The reference face is the face of a
/// or b whose normal is closest to the normal at the closest (deepest) points. The opposite face or edge is clipped against it. If the
/// minimum distance of the clipped points differs from the true distance by more than 1e-4 of the thinner shape's thickness, only the
/// closest (deepest) pair of points is added.
/// @param X_WS, X_WT world poses of shape a (frame S) and shape b (frame T), not of their links
/// @param cache [in, out] warm start of this pair
void add_convex_convex(const Collider& a, const Pose& X_WS, const Collider& b, const Pose& X_WT, double margin, GilbertCache& cache,
                       PenetrationWorkspace& workspace, Manifold& out);

/// Adds up to 6 contact points of a cylinder, ellipsoid or hull with the plane z = height [m] to `out`, with distances below `margin` [m].
/// The points of a hull are the outermost of its vertices below the margin.
/// @param hint [in, out] hulls: index of the vertex from which the search starts; afterwards of the lowest vertex
void add_convex_ground(const Collider& a, const Pose& X_WS, double height, double margin, std::int32_t& hint,
                       std::vector<ManifoldPoint>& scratch, Manifold& out);

}  // namespace ugoki::collision
