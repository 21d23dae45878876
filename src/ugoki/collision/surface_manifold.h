#pragma once
// Contact points of surfaces of triangles: non-convex meshes and height fields.

#include <vector>

#include "ugoki/collision/bubble.h"
#include "ugoki/collision/convex_mesh.h"
#include "ugoki/collision/manifold.h"
#include "ugoki/collision/penetration.h"
#include "ugoki/collision/surface.h"

namespace ugoki::collision {

/// Scratch memory; one for each thread, any pair may use it. Grows to what is needed, then keeps its size.
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

/// Adds to `out` the contact points of the convex shape a and the surface b with a distance below `margin` [m]. Each triangle within reach
/// gives its closest points; if a face of `a` rests on the triangle, the face clipped to the triangle. add_spanning() (clipping.h) then
/// keeps few of the points.
/// @param X_WS, X_WT poses of the shapes themselves
/// @param flip normals point from a to b instead of from b to a
void add_convex_surface(const Collider& a, const Pose& X_WS, const Collider& b, const Pose& X_WT, double margin, bool flip,
                        ManifoldWorkspace& workspace, Manifold& out);

/// Adds to `out` the contact points of two meshes with a distance below `margin` [m]. For triangles that pierce each other the depth is
/// that of the corners of one triangle below the plane of the other, whichever order gives the smaller depth.
void add_surface_surface(const Collider& a, const Pose& X_WS, const Collider& b, const Pose& X_WT, double margin,
                         ManifoldWorkspace& workspace, Manifold& out);

/// Adds to `out` the corners of the surface that are closer than `margin` [m] to the plane z = height; of many corners few that span them.
void add_surface_ground(const Collider& a, const Pose& X_WS, double height, double margin, ManifoldWorkspace& workspace, Manifold& out);

}  // namespace ugoki::collision
