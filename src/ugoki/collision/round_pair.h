#pragma once
// Two spheres or capsules: the pair of surface points that belongs to a pair of points on their segments.

#include "ugoki/collision/round.h"

namespace ugoki::collision {

struct RoundPair {
  Vec3 pa, pb;
  Vec3 n;  ///< unit, from b towards a
  double distance = 0;
};

/// @param sin2 square of the sine between the segments; where they touch, the normal is across both
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
