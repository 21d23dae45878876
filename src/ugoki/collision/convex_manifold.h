#pragma once
// Contact points of two convex shapes: the normal of the signed distance selects faces and edges, which are clipped against each other.

#include <vector>

#include "ugoki/collision/collider.h"
#include "ugoki/collision/manifold.h"
#include "ugoki/collision/penetration.h"

namespace ugoki::collision {

/// Adds up to 4 contact points with distances below `margin` [m] to `out`; a and b must be convex. The reference face is the face whose
/// normal is closest to the normal of the signed distance. The opposite face is clipped against it. If the minimum distance of the result
/// differs from the true distance by more than 1e-4 of the thinner shape's thickness, only the closest (deepest) pair of points is added.
/// @param X_WS, X_WT poses of the shapes themselves
/// @param cache [in, out] warm start of this pair
void add_convex_convex(const Collider& a, const Pose& X_WS, const Collider& b, const Pose& X_WT, double margin, GilbertCache& cache,
                       PenetrationWorkspace& workspace, Manifold& out);

/// Adds up to 6 contact points of a cylinder, ellipsoid or hull with the plane z = height [m] to `out`, with distances below `margin` [m].
/// Hulls: the outermost of the vertices below the margin.
/// @param hint [in, out] hulls: vertex from which the search starts; afterwards the lowest vertex
void add_convex_ground(const Collider& a, const Pose& X_WS, double height, double margin, std::int32_t& hint,
                       std::vector<ManifoldPoint>& scratch, Manifold& out);

}  // namespace ugoki::collision
