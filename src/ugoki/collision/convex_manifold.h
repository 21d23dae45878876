#pragma once
// Contact points of two convex shapes: faces, sides and edges clipped against each other from the signed distance's normal.

#include <vector>

#include "ugoki/collision/collider.h"
#include "ugoki/collision/manifold.h"
#include "ugoki/collision/penetration.h"

namespace ugoki::collision {

/// Contact points closer than `margin`, up to 4, added to `out`: the face that looks best along the shortest way clipped against
/// the face that meets it, as long as that gives the true distance (to 1e-4 of the thinner shape), otherwise the one
/// nearest or deepest pair of points. a and b convex.
/// @param X_WS, X_WT poses of the shapes themselves
void add_convex_convex(const Collider& a, const Pose& X_WS, const Collider& b, const Pose& X_WT, double margin, GilbertCache& cache,
                       PenetrationWorkspace& workspace, Manifold& out);

/// Contact points of a cylinder, ellipsoid or hull with the plane z = height, up to 6, added to `out`. Hulls: the outermost of the
/// vertices within the margin.
/// @param hint [in, out] vertex of a hull from which the search starts: the one that was lowest the last time
void add_convex_ground(const Collider& a, const Pose& X_WS, double height, double margin, std::int32_t& hint,
                       std::vector<ManifoldPoint>& scratch, Manifold& out);

}  // namespace ugoki::collision
