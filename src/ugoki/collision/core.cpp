#include "ugoki/collision/core.h"

#include <algorithm>
#include <cmath>

namespace ugoki::collision {
namespace {

/// The face that p is least far behind, and how far.
std::pair<std::size_t, double> nearest_face(const Hull& hull, const Vec3& p) {
  std::size_t face = 0;
  double least = HUGE_VAL;
  for (std::size_t f = 0; f < hull.normals.size(); ++f) {
    const double behind = hull.offsets[f] - dot(hull.normals[f], p);
    if (behind < least) {
      least = behind;
      face = f;
    }
  }
  return {face, least};
}

/// Moves p behind the faces that it is not deep enough behind, one after another.
Vec3 moved_inwards(const Hull& hull, Vec3 p, double depth, int rounds) {
  for (int k = 0; k < rounds; ++k) {
    const auto [face, behind] = nearest_face(hull, p);
    if (behind >= depth) break;
    p -= hull.normals[face] * (depth - behind);
  }
  return p;
}

/// Each vertex moved inwards until it is deep enough; what slow alternation leaves, towards a point that is deeper.
std::unique_ptr<Hull> core_of(const Hull& hull, double depth) {
  constexpr int rounds = 100;
  constexpr std::size_t many = 200;
  auto out = std::make_unique<Hull>();
  out->dimension = hull.dimension;
  const Vec3 deep = moved_inwards(hull, hull.centre, 1.1 * depth, rounds);
  const double at_deep = nearest_face(hull, deep).second;
  for (const Vec3& v : hull.vertices) {
    if (hull.vertices.size() > many) {  // smaller, about the point that is deep
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
  double least = c.thickness;
  const Hull& hull = *c.support.hull;
  for (std::size_t f = 0; f < hull.normals.size(); ++f) {
    double low = hull.offsets[f];
    for (const Vec3& v : hull.vertices) low = std::min(low, dot(hull.normals[f], v));
    least = std::min(least, 0.5 * (hull.offsets[f] - low) + c.support.radius);
  }
  return least;
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
