#pragma once
// Contact points of surfaces of triangles: non-convex meshes and height fields.

#include <vector>

#include "ugoki/collision/bubble.h"
#include "ugoki/collision/convex_mesh.h"
#include "ugoki/collision/manifold.h"
#include "ugoki/collision/penetration.h"
#include "ugoki/collision/surface.h"

namespace ugoki::collision {

/// Scratch memory for contact points; one for each thread, any pair may use it. It grows as needed and is then reused.
struct ManifoldWorkspace {
  PenetrationWorkspace penetration;
  BubbleWorkspace bubble;
  ConvexMeshWorkspace of_core;  ///< for the distance of a convex shape's core from a mesh
  Hull triangle;                ///< a triangle as a flat hull; its corners are overwritten for each triangle
  std::vector<std::int32_t> stack, triangles;
  std::vector<ManifoldPoint> points;
  std::vector<TriangleContact> pairs;

  ManifoldWorkspace();
};

/// Adds to `out` the contact points of the convex shape a and the surface b with a distance below `margin` [m]. Each triangle closer than
/// the margin gives a contact at the closest points of `a` and the triangle. If a face of `a` rests on the triangle, the triangle gives the
/// corners of this face, clipped to the triangle. add_spanning() (clipping.h) then keeps few of the points.
/// @param X_WS, X_WT world poses of shape a (frame S) and shape b (frame T), not of their links
/// @param flip true: normals point from a to b instead of from b to a
void add_convex_surface(const Collider& a, const Pose& X_WS, const Collider& b, const Pose& X_WT, double margin, bool flip,
                        ManifoldWorkspace& workspace, Manifold& out);

/// Adds to `out` the contact points of two meshes with a distance below `margin` [m]. For two triangles that pierce each other, the depth
/// is the maximum depth of the corners of one triangle below the plane of the other. The smaller of the two depths is used.
void add_surface_surface(const Collider& a, const Pose& X_WS, const Collider& b, const Pose& X_WT, double margin,
                         ManifoldWorkspace& workspace, Manifold& out);

/// Adds to `out` the corners of the surface that are closer than `margin` [m] to the plane z = height. Of many corners only a few are kept
/// (add_spanning(), clipping.h).
void add_surface_ground(const Collider& a, const Pose& X_WS, double height, double margin, ManifoldWorkspace& workspace, Manifold& out);

}  // namespace ugoki::collision
