#pragma once
// The part of a convex shape's surface with which it can lie on something: a face, a side, or a point; internal to collision.

#include <array>
#include <cstdint>

#include "ugoki/collision/collider.h"

namespace ugoki::collision {

/// A polygon (3 or more corners), a segment (2) or a point (1), in the world. What lies within `radius` of it belongs to it.
struct Patch {
  struct Corner {
    Vec3 p;                   ///< m
    std::uint32_t label = 0;  ///< which corner of the shape this is
  };
  static constexpr int most = 32;
  std::array<Corner, most> corners;
  int count = 0;
  Vec3 normal;  ///< polygon: unit, outwards
  double radius = 0;
  std::uint32_t face = 0;  ///< which face or side of the shape this is

  [[nodiscard]] const Corner& at(int i) const { return corners[static_cast<std::size_t>(i)]; }
  void add(const Vec3& p, std::uint32_t label) {
    if (count < most) corners[static_cast<std::size_t>(count++)] = {p, label};
  }
};

/// The face of the convex shape that looks best along d; a side (capsule, cylinder) where that is across d to 10 degrees; otherwise
/// the farthest point.
/// @param d unit, world
/// @param hint vertex of a hull close to the one that is farthest along d
void find_patch(const Collider& shape, const Pose& X_WS, const Vec3& d, std::int32_t hint, Patch& out);

}  // namespace ugoki::collision
