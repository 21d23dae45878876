#include "ugoki/collision/triangle_distance.h"

#include <limits>

#include "ugoki/collision/triangle_kernel.h"

namespace ugoki::collision {
namespace {

using One = Lanes<double, 1>;

/// Loads the corners so that the side from corner 0 to 1 is the longest; the orientation is kept.
void load(const TriangleCorners& t, Vec3T<One>* out) {
  const double l[3] = {dot(t[1] - t[0], t[1] - t[0]), dot(t[2] - t[1], t[2] - t[1]), dot(t[0] - t[2], t[0] - t[2])};
  const std::size_t first = l[0] >= l[1] && l[0] >= l[2] ? 0 : l[1] >= l[2] ? 1 : 2;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3& v = t[(first + k) % 3];
    out[k] = {One(v.x), One(v.y), One(v.z)};
  }
}
Vec3 from_lane(const Vec3T<One>& v) { return {v.x.v, v.y.v, v.z.v}; }

}  // namespace

TriangleDistance triangle_distance(const TriangleCorners& a, const TriangleCorners& b) {
  Vec3T<One> p[3], q[3];
  load(a, p);
  load(b, q);
  const ClosestPoints<One> best = closest_points<true>(p, q, One(std::numeric_limits<double>::infinity()));
  TriangleDistance out{std::sqrt(best.d2.v), from_lane(best.a), from_lane(best.b)};
  double sum = 0;  // not finite if any coordinate is not
  for (std::size_t k = 0; k < 3; ++k) sum += dot(a[k] - a[0], a[k] - a[0]) + dot(b[k] - a[0], b[k] - a[0]);
  if (!(sum < std::numeric_limits<double>::infinity())) out.distance = std::numeric_limits<double>::quiet_NaN();
  return out;
}

bool triangles_meet(const TriangleCorners& a, const TriangleCorners& b) {
  double size2 = 0;
  for (std::size_t k = 1; k < 3; ++k) size2 += dot(a[k] - a[0], a[k] - a[0]) + dot(b[k] - b[0], b[k] - b[0]);
  const double d = triangle_distance(a, b).distance;
  return d * d <= 1e-28 * size2;
}

TrianglePoint nearest_on_triangle(const TriangleCorners& t, const Vec3& p) {
  Vec3T<One> corner[3];
  load(t, corner);
  const Vec3T<One> q{One(p.x), One(p.y), One(p.z)};
  const Foot<One> foot(Face<One>(corner), q);
  if (foot.inside().m && std::isfinite(foot.w1.v + foot.w2.v)) return {p - from_lane(foot.up), TriangleFeature::face};
  TrianglePoint best{t[0], TriangleFeature::corner_0};
  double min_d2 = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 side = t[(k + 1) % 3] - t[k];
    const double l2 = dot(side, side), along = dot(p - t[k], side);
    TrianglePoint x;
    if (!(l2 > 0) || !(along > 0))
      x = {t[k], static_cast<TriangleFeature>(4 + k)};
    else if (along >= l2)
      x = {t[(k + 1) % 3], static_cast<TriangleFeature>(4 + (k + 1) % 3)};
    else
      x = {t[k] + side * (along / l2), static_cast<TriangleFeature>(1 + k)};
    const double d2 = dot(p - x.p, p - x.p);
    if (d2 < min_d2) {
      min_d2 = d2;
      best = x;
    }
  }
  return best;
}

}  // namespace ugoki::collision
