#pragma once
// Contact points of any two shapes.

#include "ugoki/collision/surface_manifold.h"

namespace ugoki::collision {

/// Contact points of a and b with distances below `margin`, replacing what `out` held: closed forms for spheres, capsules and boxes,
/// faces cut against each other for other convex shapes, triangles where one is not convex. A mesh that is not convex meets a
/// height field with its convex hull; two height fields do not meet.
/// @param X_WS, X_WT poses of the SHAPES themselves
/// @param cache of this pair from the last step
void find_manifold(const Collider& a, const Pose& X_WS, const Collider& b, const Pose& X_WT, double margin, GilbertCache& cache,
                   ManifoldWorkspace& workspace, Manifold& out);

/// Contact points of a with the plane z = height, n = +z, distances below `margin`.
/// @param hint [in, out] a vertex of its hull from the last step; 0 at the start
void find_ground_manifold(const Collider& a, const Pose& X_WS, double height, double margin, std::int32_t& hint,
                          ManifoldWorkspace& workspace, Manifold& out);

}  // namespace ugoki::collision
