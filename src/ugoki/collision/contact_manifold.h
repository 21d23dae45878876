#pragma once
// Contact points of any two shapes.

#include "ugoki/collision/surface_manifold.h"

namespace ugoki::collision {

/// Contact points of a and b with distances below `margin` [m]. Replaces the content of `out`.
/// - Spheres, capsules and boxes: closed forms.
/// - Other convex shapes: faces clipped against each other.
/// - One or both shapes are not convex: contacts with the triangles of the non-convex shapes.
/// - A non-convex mesh and a height field: contacts of the convex hull of the mesh with the triangles of the height field.
/// - Two height fields: no points.
/// @param X_WS, X_WT world poses of shape a (frame S) and shape b (frame T), not of their links
/// @param cache [in, out] warm start of this pair from the previous step
void find_manifold(const Collider& a, const Pose& X_WS, const Collider& b, const Pose& X_WT, double margin, GilbertCache& cache,
                   ManifoldWorkspace& workspace, Manifold& out);

/// Contact points of a with the plane z = height [m], with n = +z and distances below `margin` [m]. Replaces the content of `out`.
/// @param hint [in, out] index of the hull vertex of a that was lowest in the previous step; 0 at the start
void find_ground_manifold(const Collider& a, const Pose& X_WS, double height, double margin, std::int32_t& hint,
                          ManifoldWorkspace& workspace, Manifold& out);

}  // namespace ugoki::collision
