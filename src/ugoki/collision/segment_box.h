#pragma once
// Distance between a segment and a box, in the box's frame.

#include "ugoki/collision/round.h"

namespace ugoki::collision {

/// Closest points of a segment and a solid box, or the deepest points if they overlap.
struct SegmentBox {
  double t = 0;         ///< m: parameter of the point on the segment (Round::at())
  Vec3 on_box;          ///< m, box's frame: point on the surface of the box
  Vec3 n;               ///< unit, box's frame: from the box towards the segment
  double distance = 0;  ///< m; negative: minus the length of the shortest translation that takes the segment out of the box
  int edge = -1;        ///< axis (0, 1, 2) of the edge across which the segment leaves the box; -1: across a face, or no overlap
};

/// Closest or deepest points of a segment and a box.
/// @param s segment in the box's frame (its radius is not used)
/// @param e half extents of the box, m
[[nodiscard]] SegmentBox nearest_on_segment_and_box(const Round& s, const Vec3& e);

/// Point of the solid box with half extents e nearest to p, in the box's frame.
inline Vec3 clamp_to(const Vec3& p, const Vec3& e) { return {clamp_to(p.x, e.x), clamp_to(p.y, e.y), clamp_to(p.z, e.z)}; }

/// Clips [low, high] to the parameters at which the segment's i-th coordinate is within the box. @return false if no parameter remains
[[nodiscard]] bool cut_to_slab(const Round& s, const Vec3& e, int i, double& low, double& high);

/// The segment in the frame of a box at pose X.
inline Round in_box(const Round& s, const Pose& X) {
  return {transpose_times(X.R, s.c - X.p), transpose_times(X.R, s.d), s.half, s.radius};
}

}  // namespace ugoki::collision
