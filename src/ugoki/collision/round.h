#pragma once
// Round shapes: a sphere or capsule as a segment (of length 0 for a sphere) with a radius.

#include "ugoki/mechanism/shape.h"

namespace ugoki::collision {

/// A sphere or capsule: the segment of the points c + t d with |t| <= half, and all points within `radius` of the segment.
struct Round {
  Vec3 c;             ///< m, centre of the segment
  Vec3 d;             ///< unit, direction of the segment
  double half = 0;    ///< m, half length of the segment
  double radius = 0;  ///< m

  /// Point of the segment's line at parameter t [m].
  [[nodiscard]] Vec3 at(double t) const { return c + d * t; }
};

/// Makes the Round of a sphere or capsule; X is the pose of the shape's own frame.
inline Round make_round(const Shape& s, const Pose& X) {
  return {X.p, X.R.column(2), s.type == ShapeType::capsule ? s.half_length : 0.0, s.radius};
}

inline double clamp_to(double x, double limit) { return x < -limit ? -limit : x > limit ? limit : x; }

/// Closest points of two segments.
struct SegmentPair {
  double s = 0, t = 0;  ///< m, parameters of the closest points on a and b
  double sin2 = 0;      ///< square of the sine of the angle between the segments
};

/// Closest points of the segments of a and b; for parallel segments the middle one of all closest pairs.
/// Source: Ericson, Real-Time Collision Detection (2005), 5.1.9, with cross products in place of
/// differences of squares, so that segments close to parallel lose no digits.
[[nodiscard]] SegmentPair nearest_on_segments(const Round& a, const Round& b);

/// Interval [low, high] of a's parameter [m] that b covers: b's ends projected on a, clipped to a's length. False if the interval is empty.
[[nodiscard]] bool overlap_on(const Round& a, const Round& b, double& low, double& high);

}  // namespace ugoki::collision
