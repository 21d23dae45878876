#pragma once
// Contact points of one pair of shapes.

#include <array>
#include <cstdint>

#include "ugoki/mechanism/shape.h"

namespace ugoki::collision {

struct ManifoldPoint {
  Vec3 p;                     ///< m, half way between the surfaces along n; in the frame of the poses (usually the world)
  Vec3 n;                     ///< unit, from b towards a; in the frame of the poses
  double distance = 0;        ///< m, between the surfaces along n; negative: minus the depth of penetration
  std::uint32_t feature = 0;  ///< < 2^24: identifies the corner, edge or end of the two shapes; stable from step to step
};

/// Contact points of one pair of shapes, at most 16.
struct Manifold {
  std::array<ManifoldPoint, 16> points;
  int count = 0;

  /// Appends a point; ignored when the manifold is full.
  void add(const Vec3& p, const Vec3& n, double distance, std::uint32_t feature) {
    if (count < static_cast<int>(points.size())) points[static_cast<std::size_t>(count++)] = {p, n, distance, feature};
  }
};

/// Contact points of two spheres, capsules or boxes with distances below `margin` [m], in the frame of the poses. Replaces the
/// content of `out`. Closed forms, independent of the previous step. Other shapes: no points.
/// @param X_WS, X_WT poses of shape a (frame S) and shape b (frame T); their X_BS is not used
void find_manifold(const Shape& a, const Pose& X_WS, const Shape& b, const Pose& X_WT, double margin, Manifold& out);

/// Contact points of a sphere, capsule or box with the plane z = height [m], with normal +z and distances below `margin` [m].
/// Replaces the content of `out`. Other shapes: no points.
/// @param X_WS pose of the shape (frame S); its X_BS is not used
void find_ground_manifold(const Shape& a, const Pose& X_WS, double height, double margin, Manifold& out);

/// True for shapes whose manifolds have a closed form: sphere, capsule, box.
[[nodiscard]] inline bool is_simple(ShapeType t) { return t == ShapeType::sphere || t == ShapeType::capsule || t == ShapeType::box; }

}  // namespace ugoki::collision
