#pragma once
// Two boxes.

#include "ugoki/collision/manifold.h"

namespace ugoki::collision {

struct Box {
  Pose X;  ///< the box's frame
  Vec3 e;  ///< m, half extents
};

/// Nearest or deepest pair of points of two boxes, in the frame of the poses.
struct BoxPair {
  Vec3 pa, pb;
  Vec3 n;  ///< unit, from b towards a
  double distance = 0;
};

/// Exact: separating axes where the boxes meet, edges against boxes where they do not.
[[nodiscard]] BoxPair nearest_on_boxes(const Box& a, const Box& b);

/// Contact points closer than `margin`, up to 4, added to `out`: the nearest face clipped against the other box, or one
/// point where edges or corners are nearer than any face.
void add_box_box(const Box& a, const Box& b, double margin, Manifold& out);

}  // namespace ugoki::collision
