#pragma once
// Distance, penetration depth and contact points of two boxes.

#include "ugoki/collision/manifold.h"

namespace ugoki::collision {

struct Box {
  Pose X;  ///< m: pose of the box; its origin is the box's centre
  Vec3 e;  ///< m: half extents along the axes of X
};

/// Closest points of two boxes, or deepest points where they overlap, in the frame of the poses. pa - pb = n * distance.
struct BoxPair {
  Vec3 pa, pb;          ///< m: points on a and b
  Vec3 n;               ///< unit, from b towards a
  double distance = 0;  ///< m; negative: penetration depth
};

/// Closest (deepest) points of two boxes, exact up to rounding. Overlapping boxes: separating axis test. Separate boxes: distances of
/// edges and corners to the other box.
[[nodiscard]] BoxPair nearest_on_boxes(const Box& a, const Box& b);

/// Adds up to 4 contact points with distances below `margin` [m] to `out`: the best separating face with the other box's face clipped
/// against it, or one point if edges or corners are closer than the faces.
void add_box_box(const Box& a, const Box& b, double margin, Manifold& out);

}  // namespace ugoki::collision
