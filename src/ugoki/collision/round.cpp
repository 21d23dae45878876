#include "ugoki/collision/round.h"

#include <algorithm>

namespace ugoki::collision {

bool overlap_on(const Round& a, const Round& b, double& low, double& high) {
  const double middle = dot(a.d, b.c - a.c), reach = b.half * std::fabs(dot(a.d, b.d));
  low = std::max(-a.half, middle - reach);
  high = std::min(a.half, middle + reach);
  return low <= high;
}

SegmentPair nearest_on_segments(const Round& a, const Round& b) {
  const Vec3 r = a.c - b.c;
  const Vec3 axis = cross(a.d, b.d);
  const double cosine = dot(a.d, b.d), c = dot(a.d, r), f = dot(b.d, r);
  SegmentPair out;
  out.sin2 = dot(axis, axis);
  double s;
  if (out.sin2 > 1e-24) {
    s = clamp_to(-dot(cross(r, b.d), axis) / out.sin2, a.half);
  } else {
    double low, high;
    s = overlap_on(a, b, low, high) ? 0.5 * (low + high) : clamp_to(-c, a.half);
  }
  const double t = cosine * s + f;
  out.t = clamp_to(t, b.half);
  out.s = t == out.t ? s : clamp_to(cosine * out.t - c, a.half);
  return out;
}

}  // namespace ugoki::collision
