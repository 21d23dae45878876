#pragma once
// A patch is the part of a convex shape's surface with which the shape can rest on another shape: a face, a straight side or a point.
// Internal to collision/.

#include <array>
#include <cstdint>

#include "ugoki/collision/collider.h"

namespace ugoki::collision {

/// A polygon (3 or more corners), a segment (2) or a point (1), inflated by `radius`. Coordinates are in the frame W of the shape's pose
/// X_WS that find_patch() receives; W is usually the world frame.
struct Patch {
  struct Corner {
    Vec3 p;                   ///< m
    std::uint32_t label = 0;  ///< identifies the corner within the shape; stable from step to step
  };
  static constexpr int max_corners = 32;
  std::array<Corner, max_corners> corners;
  int count = 0;
  Vec3 normal;             ///< polygon only: unit, outwards
  double radius = 0;       ///< m: radius by which the patch is inflated (spheres, capsules, inflated shapes)
  std::uint32_t face = 0;  ///< index of the face or side within the shape

  [[nodiscard]] const Corner& at(int i) const { return corners[static_cast<std::size_t>(i)]; }
  /// Appends a corner; ignored when the patch is full.
  void add(const Vec3& p, std::uint32_t label) {
    if (count < max_corners) corners[static_cast<std::size_t>(count++)] = {p, label};
  }
};

/// Finds the patch of a convex shape in direction d: the face whose outward normal is closest to d (box, hull, end of a cylinder); the
/// side of a capsule or cylinder if it is perpendicular to d within 10 degrees; otherwise the farthest point along d.
/// @param X_WS pose of the shape in the frame W, usually the world frame
/// @param d unit, in the frame W
/// @param hint hulls: index of a vertex near the one that is farthest along d; starts the search
void find_patch(const Collider& shape, const Pose& X_WS, const Vec3& d, std::int32_t hint, Patch& out);

}  // namespace ugoki::collision
