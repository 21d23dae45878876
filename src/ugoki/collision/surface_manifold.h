#pragma once
// Contact points of surfaces made of triangles: meshes that are not convex, and height fields.

#include <vector>

#include "ugoki/collision/bubble.h"
#include "ugoki/collision/convex_mesh.h"
#include "ugoki/collision/manifold.h"
#include "ugoki/collision/penetration.h"
#include "ugoki/collision/surface.h"

namespace ugoki::collision {

/// Scratch memory; one for each thread, any pair may use it. Grows to what is needed, then stays.
struct ManifoldWorkspace {
  PenetrationWorkspace penetration;
  BubbleWorkspace bubble;
  ConvexMeshWorkspace of_core;
  Hull triangle;  ///< one triangle as a flat hull, its corners set anew for each
  std::vector<std::int32_t> stack, triangles;
  std::vector<ManifoldPoint> points;
  std::vector<TriangleContact> pairs;

  ManifoldWorkspace();
};

/// Contact points of the convex shape a and the surface b closer than `margin`, added to `out`: of each triangle within reach the
/// nearest points, and the face of `a` cut against it where they lie on each other; few of them that span the rest.
/// @param X_WS, X_WT poses of the shapes themselves
void add_convex_surface(const Collider& a, const Pose& X_WS, const Collider& b, const Pose& X_WT, double margin, bool flip,
                        ManifoldWorkspace& workspace, Manifold& out);

/// The same for two surfaces, at least one of them a mesh. Where triangles pierce each other the depth is that of the corners of one
/// below the plane of the other, whichever is less.
void add_surface_surface(const Collider& a, const Pose& X_WS, const Collider& b, const Pose& X_WT, double margin,
                         ManifoldWorkspace& workspace, Manifold& out);

/// Corners of the surface closer than `margin` to the plane z = height, few of them that span the rest.
void add_surface_ground(const Collider& a, const Pose& X_WS, double height, double margin, ManifoldWorkspace& workspace, Manifold& out);

}  // namespace ugoki::collision
