#pragma once
// Contact points (the result of collision analysis and the input of contact forces) and the ground plane.

#include <cstdint>

#include "ugoki/spatial/vec3.h"

namespace ugoki::collision {

/// One point at which two bodies touch, overlap, or come closer than the margin of the search.
struct ContactPoint {
  int system_a = -1, link_a = -1;  ///< body a: indices of its mechanism in the scene and of its link in the mechanism
  int system_b = -1, link_b = -1;  ///< body b: indices of its mechanism and of its link; -1, -1: the ground
  Vec3 p;                          ///< m, world: midpoint between the two surfaces along n
  Vec3 n;                          ///< unit, world: from b towards a
  double distance = 0;             ///< m, between the surfaces along n; negative: minus the depth of penetration
  double friction = 0;             ///< Coulomb coefficient of the pair
  double restitution = 0;          ///< coefficient of restitution of the pair, 0 ... 1
  std::uint64_t key = 0;           ///< identifies the two shapes and their features; stable from step to step, for warm starts
};

/// The horizontal plane z = height; everything below it is ground.
struct Ground {
  double height = 0;       ///< m
  double friction = 0.9;   ///< Coulomb coefficient
  double restitution = 0;  ///< 0 ... 1
};

}  // namespace ugoki::collision
