#include "ugoki/collision/clipping.h"

#include <algorithm>
#include <utility>

namespace ugoki::collision {
namespace {

/// A corner of the polygon during clipping. in, out: labels of the two edges that meet at the corner.
struct Clipped {
  Vec3 p;
  std::uint32_t in, out;
};
struct Polygon {
  std::array<Clipped, 2 * Patch::max_corners> corners;
  int count = 0;
  void add(const Clipped& c) {
    if (count < static_cast<int>(corners.size())) corners[static_cast<std::size_t>(count++)] = c;
  }
  [[nodiscard]] const Clipped& at(int i) const { return corners[static_cast<std::size_t>(i)]; }
};

/// Clips a polygon, or a segment of two points, to the half-space m . p <= limit.
/// @param label label of the clipping plane
void clip(const Polygon& from, const Vec3& m, double limit, std::uint32_t label, Polygon& to) {
  to.count = 0;
  const bool closed = from.count > 2;
  for (int i = 0; i < from.count; ++i) {
    const Clipped& c = from.at(i);
    const double beyond_c = dot(m, c.p) - limit;
    if (beyond_c <= 0) to.add(c);
    if (!closed && i + 1 == from.count) continue;
    const Clipped& d = from.at((i + 1) % from.count);
    const double beyond_d = dot(m, d.p) - limit;
    if ((beyond_c <= 0) == (beyond_d <= 0)) continue;
    const double f = beyond_c / (beyond_c - beyond_d);
    Clipped cut{c.p + (d.p - c.p) * f, c.out, label};
    if (beyond_c > 0) std::swap(cut.in, cut.out);
    to.add(cut);
  }
}

constexpr double same_direction_cos = 0.95;  // cosine of 18 degrees: normals within this angle form one group

/// Sets `chosen` to the indices of the four outermost points in the projection along n; -1 replaces missing points (collinear points).
/// The tolerances (1e-6, relative) keep the choice stable from step to step when two points are equally far out.
void outermost(std::span<const ManifoldPoint> points, const Vec3& n, int (&chosen)[4]) {
  const Vec3 u = any_perpendicular(n), v = cross(n, u);
  const auto at = [&](int i) -> const Vec3& { return points[static_cast<std::size_t>(i)].p; };
  const int count = static_cast<int>(points.size());
  const auto best = [&](const auto& score, double maximum) {
    int found = -1;
    for (int i = 0; i < count; ++i)
      if (const double m = score(at(i)); m > maximum + 1e-6 * std::fabs(maximum)) {
        maximum = m;
        found = i;
      }
    return found;
  };
  chosen[0] = best([&](const Vec3& p) { return dot(u, p) + 1e-3 * dot(v, p); }, -1e300);
  const Vec3 o = at(chosen[0]);
  const auto flat = [&](const Vec3& p) { return p - o - n * dot(n, p - o); };
  chosen[1] = best([&](const Vec3& p) { return dot(flat(p), flat(p)); }, 1e-18);
  chosen[2] = chosen[3] = -1;
  if (chosen[1] < 0) return;
  const Vec3 line = flat(at(chosen[1])), across = cross(n, line);
  const double slack = 1e-6 * dot(line, line);
  chosen[2] = best([&](const Vec3& p) { return dot(across, p - o); }, slack);
  chosen[3] = best([&](const Vec3& p) { return -dot(across, p - o); }, slack);
}

}  // namespace

std::uint32_t feature_hash(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
  std::uint32_t h = 2166136261U;
  for (const std::uint32_t x : {a, b, c, d}) {
    h = (h ^ x) * 16777619U;
    h ^= h >> 13;
  }
  return (h ^ (h >> 24)) & 0xffffffU;
}

void cut(const Patch& reference, const Patch& incident, const Vec3& n, std::uint32_t side, Candidates& out) {
  out.count = 0;
  Polygon one, two;
  Polygon *now = &one, *next = &two;
  for (int i = 0; i < incident.count; ++i)
    now->add({incident.at(i).p, incident.at((i + incident.count - 1) % incident.count).label, incident.at(i).label});
  if (reference.count == 2) {
    const Vec3 along = normalized(reference.at(1).p - reference.at(0).p);
    clip(*now, along, dot(along, reference.at(1).p), 1U << 30, *next);
    clip(*next, -along, -dot(along, reference.at(0).p), (1U << 30) + 1, *now);
  } else {
    for (int i = 0; i < reference.count; ++i) {
      const Vec3& from = reference.at(i).p;
      const Vec3 edge = reference.at((i + 1) % reference.count).p - from;
      const Vec3 outward = normalized(cross(edge, n), {});
      // Stacked shapes of equal size keep their own corners, despite rounding: the planes are moved outwards by 1e-6 of the edge's length.
      clip(*now, outward, dot(outward, from) + 1e-6 * norm(edge), (1U << 30) + reference.at(i).label, *next);
      std::swap(now, next);
    }
  }
  const double base = dot(n, reference.at(0).p);
  for (int i = 0; i < now->count; ++i) {
    const Clipped& c = now->at(i);
    const double h = dot(n, c.p) - base - incident.radius - reference.radius;
    out.add({c.p - n * incident.radius, h, feature_hash(side, reference.face, c.in, c.out)});
  }
}

double min_height(const Candidates& c) {
  double h = 1e300;
  for (int i = 0; i < c.count; ++i) h = std::min(h, c.at(i).h);
  return h;
}

void add_spanning(std::span<ManifoldPoint> points, double slack, Manifold& out) {
  while (!points.empty() && out.count < static_cast<int>(out.points.size())) {
    const ManifoldPoint deepest = *std::min_element(points.begin(), points.end(),
                                                    [](const ManifoldPoint& a, const ManifoldPoint& b) { return a.distance < b.distance; });
    std::size_t count = 0;
    for (ManifoldPoint& p : points)
      if (dot(p.n, deepest.n) > same_direction_cos) std::swap(points[count++], p);
    const std::span<ManifoldPoint> group = points.first(count);
    int chosen[4];
    outermost(group, deepest.n, chosen);
    double minimum = 1e300;
    for (int k = 0; k < 4; ++k) {
      if (chosen[k] < 0 || std::find(chosen, chosen + k, chosen[k]) != chosen + k) continue;
      const ManifoldPoint& p = group[static_cast<std::size_t>(chosen[k])];
      minimum = std::min(minimum, p.distance);
      out.add(p.p, p.n, p.distance, p.feature);
    }
    if (deepest.distance < minimum - slack) out.add(deepest.p, deepest.n, deepest.distance, deepest.feature);
    points = points.subspan(group.size());
  }
}

}  // namespace ugoki::collision
