#pragma once
// Signed distance between any two shapes: closed forms for spheres, capsules and boxes, and Gilbert's method for other convex shapes.
// Non-convex shapes that are far apart: Gilbert's method on their convex hulls. Non-convex shapes that are near: the bubble method, a
// search of sphere trees over the triangles. Source: Nagashima (1999) section 6.1.

#include <cstdint>
#include <limits>

#include "ugoki/collision/bubble.h"
#include "ugoki/collision/collider.h"
#include "ugoki/collision/convex_mesh.h"
#include "ugoki/collision/penetration.h"
#include "ugoki/spatial/spatial.h"

namespace ugoki::collision {

/// The method that computed a distance.
enum class DistanceMethod : std::uint8_t {
  none,         ///< no result: a pose is not finite, or a shape has no surface
  closed_form,  ///< formula for spheres, capsules and boxes
  gilbert,      ///< Gilbert's method on two convex shapes
  hulls,        ///< Gilbert's method on the convex hulls, where at least one shape is not convex
  bubble,       ///< search of sphere trees over the triangles (bubble.h, convex_mesh.h), where at least one shape is not convex
};

/// Distance between two shapes a and b. pa - pb = n * distance.
struct PairDistance {
  double distance = 0;  ///< m, between the surfaces; negative: minus the penetration depth; infinite: unknown
  double lower = 0;     ///< m: proved lower bound of the true distance; -infinity: unknown
  Vec3 pa, pb;          ///< m, world: a closest (deepest) pair of points on a and b
  Vec3 n;               ///< unit, world: from b towards a; zero where surfaces of triangles pierce each other
  bool exact = false;   ///< false: only `lower` is valid
  DistanceMethod method = DistanceMethod::none;
};

/// Warm start of one pair, kept from one query to the next. A default-constructed cache is empty; a wrong cache costs time but does not
/// change the result.
struct PairCache {
  GilbertCache gilbert;
  TrianglePair triangles;       ///< two meshes: the closest triangles of the last query
  ConvexMeshCache convex_mesh;  ///< a convex shape and a mesh: the closest triangle of the last query
  bool near = false;            ///< method with which the next query starts; true: the triangles; false: the convex hulls
};

/// Scratch memory of find_pair_distance(); one for each thread, any pair may use it. It grows as needed and is then reused.
struct DistanceWorkspace {
  PenetrationWorkspace penetration;
  BubbleWorkspace bubble;
  ConvexMeshWorkspace convex_mesh;
};

/// Signed distance between a at pose X_WS and b at pose X_WT, poses of the SHAPES (X_WB * shape.X_BS).
/// Depth of penetration: for convex shapes the length of the shortest translation that separates them; for two closed meshes the depth of
/// the deepest vertex (mesh_point.h); for other shapes 0 if their surfaces pierce each other. A body that is wholly inside a mesh has a
/// positive distance from the mesh's surface.
///
/// The method for pairs with a non-convex shape: the distance between the convex hulls is the result if it is exact or at least `cutoff`.
/// It is exact if the closest feature of each non-convex shape's hull is a single vertex, which belongs to the shape too. Otherwise the
/// triangles are compared. Later queries keep comparing triangles until the hulls are farther apart than min(cutoff, 0.25 r) + 0.02 r,
/// where r is the smaller bounding radius (hysteresis).
/// No allocation after the workspace has grown.
/// @param cutoff m: for a larger distance the result may be exact = false with `lower` >= cutoff; infinity: always exact
[[nodiscard]] PairDistance find_pair_distance(const Collider& a, const Pose& X_WS, const Collider& b, const Pose& X_WT, double cutoff,
                                              PairCache& cache, DistanceWorkspace& workspace);

/// True for sphere, capsule and box: closed_form_distance() accepts them.
[[nodiscard]] inline bool has_closed_form(ShapeType t) { return t == ShapeType::sphere || t == ShapeType::capsule || t == ShapeType::box; }
/// Signed distance between two shapes for which has_closed_form() is true. Exact up to rounding, O(1). X_WS, X_WT: poses of the SHAPES.
[[nodiscard]] PairDistance closed_form_distance(const Shape& a, const Pose& X_WS, const Shape& b, const Pose& X_WT);

}  // namespace ugoki::collision
