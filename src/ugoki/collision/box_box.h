#pragma once
// Distance, penetration depth and contact points of two boxes.

#include "ugoki/collision/manifold.h"

namespace ugoki::collision {

struct Box {
  Pose X;  ///< m: pose of the box; its origin is the box's centre
  Vec3 e;  ///< m: half extents along the axes of X
};

/// Closest points of two boxes a and b, or their deepest points if they overlap. All values are in the frame in which the poses are given.
/// pa - pb = n * distance.
struct BoxPair {
  Vec3 pa, pb;          ///< m: points on a and b
  Vec3 n;               ///< unit, from b towards a
  double distance = 0;  ///< m, between the surfaces; negative: minus the penetration depth
};

/// Closest (deepest) points of two boxes, exact up to rounding. Overlapping boxes: separating axis test. Separate boxes: distances of edges
/// and corners from the other box.
[[nodiscard]] BoxPair nearest_on_boxes(const Box& a, const Box& b);

/// Adds up to 4 contact points of two boxes with distances below `margin` [m] to `out`. They are the corners of a face of one box, clipped
/// to the best separating face of the other box. If edges or corners are closer than the faces, only one point is added.
void add_box_box(const Box& a, const Box& b, double margin, Manifold& out);

}  // namespace ugoki::collision
