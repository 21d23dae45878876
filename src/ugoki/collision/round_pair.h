#pragma once
// Two spheres or capsules: surface points, normal and distance for a given pair of points on their segments.

#include "ugoki/collision/round.h"

namespace ugoki::collision {

/// A pair of points on the surfaces of two round shapes. pa - pb = n * distance.
struct RoundPair {
  Vec3 pa, pb;          ///< m
  Vec3 n;               ///< unit, from b towards a
  double distance = 0;  ///< m, between the surfaces; negative: minus the penetration depth
};

/// Surface points of a and b for given points on their segments, at parameters s and t [m]. If these two points coincide, the normal is
/// perpendicular to both segments, or to the only one of non-zero length; for two spheres it is +z.
/// @param sin2 square of the sine of the angle between the segments
[[nodiscard]] inline RoundPair round_pair_at(const Round& a, const Round& b, double s, double t, double sin2) {
  const Vec3 on_a = a.at(s), on_b = b.at(t), gap = on_a - on_b;
  const double d = norm(gap);
  RoundPair out;
  if (d > 1e-12 * (a.radius + b.radius + a.half + b.half))
    out.n = gap / d;
  else if (a.half > 0 && b.half > 0 && sin2 > 1e-12)
    out.n = normalized(cross(a.d, b.d));
  else if (a.half > 0)
    out.n = any_perpendicular(a.d);
  else if (b.half > 0)
    out.n = any_perpendicular(b.d);
  else
    out.n = {0, 0, 1};
  out.distance = dot(gap, out.n) - a.radius - b.radius;
  out.pa = on_a - out.n * a.radius;
  out.pb = on_b + out.n * b.radius;
  return out;
}

}  // namespace ugoki::collision
