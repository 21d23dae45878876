#include "ugoki/collision/core.h"

#include <algorithm>
#include <cmath>

namespace ugoki::collision {
namespace {

/// Index of the face whose plane is closest to p, and the depth [m] of p below this plane; negative: p is outside the hull.
std::pair<std::size_t, double> nearest_face(const Hull& hull, const Vec3& p) {
  std::size_t face = 0;
  double minimum = HUGE_VAL;
  for (std::size_t f = 0; f < hull.normals.size(); ++f) {
    const double behind = hull.offsets[f] - dot(hull.normals[f], p);
    if (behind < minimum) {
      minimum = behind;
      face = f;
    }
  }
  return {face, minimum};
}

/// Moves p inwards by alternating projection. Each round moves p to `depth` [m] below the face closest to p. Ends when p is deep enough
/// below all faces, or after `rounds` rounds.
Vec3 moved_inwards(const Hull& hull, Vec3 p, double depth, int rounds) {
  for (int k = 0; k < rounds; ++k) {
    const auto [face, behind] = nearest_face(hull, p);
    if (behind >= depth) break;
    p -= hull.normals[face] * (depth - behind);
  }
  return p;
}

/// Hull of the vertices, each moved inwards to `depth` [m] below all faces. A vertex that is not deep enough after all rounds is moved
/// towards a deep point of the hull. Hulls with more than 200 vertices are scaled about the deep point instead, because the projections
/// would be slow.
std::unique_ptr<Hull> core_of(const Hull& hull, double depth) {
  constexpr int rounds = 100;
  constexpr std::size_t max_projected = 200;
  auto out = std::make_unique<Hull>();
  out->dimension = hull.dimension;
  const Vec3 deep = moved_inwards(hull, hull.centre, 1.1 * depth, rounds);
  const double at_deep = nearest_face(hull, deep).second;
  for (const Vec3& v : hull.vertices) {
    if (hull.vertices.size() > max_projected) {  // too many vertices: scaled about the deep point
      out->vertices.push_back(deep + (v - deep) * std::max(1 - depth / at_deep, 0.0));
      continue;
    }
    Vec3 p = moved_inwards(hull, v, depth, rounds);
    const double behind = nearest_face(hull, p).second;
    if (behind < depth) p = at_deep > depth ? p + (deep - p) * ((depth - behind) / (at_deep - behind)) : deep;
    out->vertices.push_back(p);
  }
  out->centre = deep;
  for (const Vec3& p : out->vertices) out->radius = std::max(out->radius, norm(p - deep));
  return out;
}

}  // namespace

double half_width_of(const Collider& c) {
  if (c.support.kind != SupportKind::hull || c.support.hull == nullptr) return c.thickness;
  double minimum = c.thickness;
  const Hull& hull = *c.support.hull;
  for (std::size_t f = 0; f < hull.normals.size(); ++f) {
    double low = hull.offsets[f];
    for (const Vec3& v : hull.vertices) low = std::min(low, dot(hull.normals[f], v));
    minimum = std::min(minimum, 0.5 * (hull.offsets[f] - low) + c.support.radius);
  }
  return minimum;
}

std::shared_ptr<const Core> make_core(const Collider& c) {
  const double depth = 0.5 * half_width_of(c);
  auto made = std::make_shared<Core>();
  Core& out = *made;
  out.collider = c;
  out.depth = depth;
  Support& s = out.collider.support;
  const auto less = [&](double x) { return std::max(x - depth, 0.0); };
  switch (s.kind) {
    case SupportKind::point:
    case SupportKind::segment: s.radius = less(s.radius); break;
    case SupportKind::box: s.size = {less(s.size.x), less(s.size.y), less(s.size.z)}; break;
    case SupportKind::cylinder: s.size = {less(s.size.x), less(s.size.y), less(s.size.z)}; break;
    case SupportKind::ellipsoid: s.size = s.size * (1 - depth / std::min({s.size.x, s.size.y, s.size.z})); break;
    case SupportKind::hull:
      out.hull = core_of(*s.hull, depth);
      s.hull = out.hull.get();
      break;
    case SupportKind::half_space: break;
  }
  return made;
}

}  // namespace ugoki::collision
