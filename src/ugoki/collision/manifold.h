#pragma once
// Contact points of one pair of shapes.

#include <array>
#include <cstdint>

#include "ugoki/mechanism/shape.h"

namespace ugoki::collision {

struct ManifoldPoint {
  Vec3 p;                     ///< m, half way between the surfaces along n
  Vec3 n;                     ///< unit, from b towards a
  double distance = 0;        ///< m, negative: depth
  std::uint32_t feature = 0;  ///< below 2^24; which corner, edge or end of the two shapes
};

struct Manifold {
  std::array<ManifoldPoint, 16> points;
  int count = 0;

  void add(const Vec3& p, const Vec3& n, double distance, std::uint32_t feature) {
    if (count < static_cast<int>(points.size())) points[static_cast<std::size_t>(count++)] = {p, n, distance, feature};
  }
};

/// Contact points of two spheres, capsules or boxes with distances below `margin`, in the frame of the poses; replaces what
/// `out` held. Closed forms, no memory of the last step.
/// @param X_WS, X_WT poses of the SHAPES themselves (their X_BS is not used)
void find_manifold(const Shape& a, const Pose& X_WS, const Shape& b, const Pose& X_WT, double margin, Manifold& out);

/// Contact points of a sphere, capsule or box with the plane z = height, n = +z, distances below `margin`.
/// @param X_WS pose of the shape itself
void find_ground_manifold(const Shape& a, const Pose& X_WS, double height, double margin, Manifold& out);

/// Has it a closed form? Sphere, capsule, box.
[[nodiscard]] inline bool is_simple(ShapeType t) { return t == ShapeType::sphere || t == ShapeType::capsule || t == ShapeType::box; }

}  // namespace ugoki::collision
