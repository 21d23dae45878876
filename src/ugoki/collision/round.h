#pragma once
// Spheres and capsules as one kind of thing: a segment (perhaps of length 0) with a radius.

#include "ugoki/mechanism/shape.h"

namespace ugoki::collision {

/// Points c + t d, |t| <= half, and everything within `radius` of them.
struct Round {
  Vec3 c;           ///< m
  Vec3 d;           ///< unit
  double half = 0;  ///< m
  double radius = 0;

  [[nodiscard]] Vec3 at(double t) const { return c + d * t; }
};

/// A sphere or capsule at pose X of its own frame.
inline Round make_round(const Shape& s, const Pose& X) {
  return {X.p, X.R.column(2), s.type == ShapeType::capsule ? s.half_length : 0.0, s.radius};
}

inline double clamp_to(double x, double limit) { return x < -limit ? -limit : x > limit ? limit : x; }

/// Nearest points of two segments: parameters and the square of the sine of the angle between them.
struct SegmentPair {
  double s = 0, t = 0;
  double sin2 = 0;
};

/// Where several pairs are nearest (parallel segments) it takes the middle of them.
/// Source: Ericson, Real-Time Collision Detection (2005), 5.1.9, with cross products in place of
/// differences of squares, so that segments close to parallel lose no digits.
[[nodiscard]] SegmentPair nearest_on_segments(const Round& a, const Round& b);

/// Interval of a's parameter over which b lies beside it (b's ends projected on a, cut to a's length);
/// false where it is empty.
[[nodiscard]] bool overlap_on(const Round& a, const Round& b, double& low, double& high);

}  // namespace ugoki::collision
