#pragma once
// True distance of two shapes, whatever they are: closed forms, Gilbert's method for convex shapes, bubble for the others, and the
// switch between the last two by the distance of the convex hulls.
// Source: Nagashima (1999) section 6.1.

#include <cstdint>
#include <limits>

#include "ugoki/collision/bubble.h"
#include "ugoki/collision/collider.h"
#include "ugoki/collision/convex_mesh.h"
#include "ugoki/collision/penetration.h"
#include "ugoki/spatial/spatial.h"

namespace ugoki::collision {

/// What found a distance.
enum class DistanceMethod : std::uint8_t {
  none,         ///< nothing: a pose that is not finite, or a shape without surface
  closed_form,  ///< sphere, capsule, box
  gilbert,      ///< convex shapes
  hulls,        ///< Gilbert's method on the convex hull of a shape that is not convex
  bubble,       ///< surfaces of triangles
};

/// pa - pb = n * distance.
struct PairDistance {
  double distance = 0;  ///< m, between the surfaces; negative: depth of penetration
  double lower = 0;     ///< m: the true distance is not below; -infinity where nothing is known
  Vec3 pa, pb;          ///< m, world: a nearest (deepest) pair of points on a and b
  Vec3 n;               ///< unit, world: from b towards a; zero where surfaces of triangles pierce each other
  bool exact = false;   ///< false: only `lower` holds
  DistanceMethod method = DistanceMethod::none;
};

/// What a pair remembers from one query to the next. A new one knows nothing; a wrong one costs time, never truth.
struct PairCache {
  GilbertCache gilbert;
  TrianglePair triangles;       ///< two meshes: the nearest
  ConvexMeshCache convex_mesh;  ///< convex shape and mesh
  bool near = false;            ///< the side of the switch: the surfaces of triangles were compared the last time
};

/// Scratch memory; one for each thread, any pair may use it. Grows, then stays.
struct DistanceWorkspace {
  PenetrationWorkspace penetration;
  BubbleWorkspace bubble;
  ConvexMeshWorkspace convex_mesh;
};

/// Signed distance of a at pose X_WS and b at pose X_WT, poses of the SHAPES (X_WB * shape.X_BS). Depths: of convex shapes the shortest
/// translation that separates them; of two closed meshes that of the deepest vertex (mesh_point.h); otherwise 0 where surfaces pierce
/// each other. A body that is wholly inside a mesh has a distance from its surface.
///
/// The switch, for pairs of which one is not convex: where the hulls are farther apart than `enough`, that is the answer (exact =
/// false, `lower` not below enough; exact where vertices of the hulls are nearest, as these belong to the shapes). Otherwise the triangles
/// are compared, and that is gone on with until the hulls are apart by a little more (a fiftieth of the smaller body) than `enough`.
/// @param enough m: greater distances are of no interest: exact = false and some `lower` not below it will do. Infinity: always exact
/// No allocation after the workspace has grown.
[[nodiscard]] PairDistance find_pair_distance(const Collider& a, const Pose& X_WS, const Collider& b, const Pose& X_WT, double enough,
                                              PairCache& cache, DistanceWorkspace& workspace);

/// Sphere, capsule and box.
[[nodiscard]] inline bool has_closed_form(ShapeType t) { return t == ShapeType::sphere || t == ShapeType::capsule || t == ShapeType::box; }
/// Exact up to rounding, O(1). Both shapes must have a closed form; X_WS, X_WT as above.
[[nodiscard]] PairDistance closed_form_distance(const Shape& a, const Pose& X_WS, const Shape& b, const Pose& X_WT);

}  // namespace ugoki::collision
