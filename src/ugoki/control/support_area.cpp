#include "ugoki/control/support_area.h"

#include <algorithm>

namespace ugoki::control {

double distance_to_edge(std::vector<Vec3>& points, const Vec3& p, Vec3& closest) {
  // Convex hull by the monotone chain (Andrew 1979), counter-clockwise, stored after the points.
  std::sort(points.begin(), points.end(), [](const Vec3& a, const Vec3& b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
  const std::size_t n = points.size();
  const auto turn = [](const Vec3& o, const Vec3& a, const Vec3& b) { return (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x); };
  for (int pass = 0; pass < 2; ++pass) {
    const std::size_t start = points.size();
    for (std::size_t k = 0; k < n; ++k) {
      const Vec3 q = points[pass == 0 ? k : n - 1 - k];
      while (points.size() >= start + 2 && turn(points[points.size() - 2], points.back(), q) <= 0) points.pop_back();
      points.push_back(q);
    }
    points.pop_back();
  }
  const std::size_t corners = points.size() - n;
  double inside = 1e3, best = 1e300;
  const Vec3 flat{p.x, p.y, 0};
  for (std::size_t k = 0; k < std::max<std::size_t>(1, corners); ++k) {
    const Vec3 a = corners ? points[n + k] : points[0], b = corners ? points[n + (k + 1) % corners] : points[0];
    const Vec3 edge = b - a;
    const double length = norm(edge);
    const double s = length > 0 ? std::clamp(dot(flat - a, edge) / (length * length), 0.0, 1.0) : 0;
    const Vec3 q = a + edge * s;
    if (norm(flat - q) < best) {
      best = norm(flat - q);
      closest = q;
    }
    inside = std::min(inside, length > 0 ? turn(a, b, flat) / length : -best);
  }
  if (corners < 3 || inside < 0) return -best;
  closest = flat;
  return inside;
}

}  // namespace ugoki::control
