#pragma once
// Oracles for distances and depths of convex shapes, independent of the code under test; and random convex shapes.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "random_shapes.h"
#include "ugoki/collision/penetration.h"
#include "ugoki/geometry/make_hull.h"

namespace ugoki::collision::test {

/// Maximum of n . x [m] over all points x of the core (the shape without its radius). For hulls computed over all vertices.
inline double reach(const Support& s, const Pose& X, const Vec3& n) {
  const Vec3 m = transpose_times(X.R, n);
  double r = 0;
  switch (s.kind) {
    case SupportKind::point: break;
    case SupportKind::segment: r = s.size.z * std::fabs(m.z); break;
    case SupportKind::box: r = s.size.x * std::fabs(m.x) + s.size.y * std::fabs(m.y) + s.size.z * std::fabs(m.z); break;
    case SupportKind::cylinder: r = s.size.x * std::sqrt(m.x * m.x + m.y * m.y) + s.size.z * std::fabs(m.z); break;
    case SupportKind::ellipsoid: r = norm(Vec3{s.size.x * m.x, s.size.y * m.y, s.size.z * m.z}); break;
    case SupportKind::hull:
      r = -1e300;
      for (const Vec3& v : s.hull->vertices) r = std::max(r, dot(m, v));
      break;
    case SupportKind::half_space: return std::fabs(m.x) + std::fabs(m.y) < 1e-12 && m.z > 0 ? dot(n, X.p) : 1e300;
  }
  return r + dot(n, X.p);
}

/// Lower bound [m] of the distance from p (world) to the core (the shape without its radius); at most 0 if p is inside.
inline double outside(const Support& s, const Pose& X, const Vec3& p) {
  const Vec3 q = transpose_times(X.R, p - X.p), h = s.size;
  switch (s.kind) {
    case SupportKind::point: return norm(q);
    case SupportKind::segment: return norm(q - Vec3{0, 0, std::clamp(q.z, -h.z, h.z)});
    case SupportKind::box: return std::max({std::fabs(q.x) - h.x, std::fabs(q.y) - h.y, std::fabs(q.z) - h.z});
    case SupportKind::cylinder: return std::max(std::sqrt(q.x * q.x + q.y * q.y) - h.x, std::fabs(q.z) - h.z);
    case SupportKind::ellipsoid: {
      const double k = norm(Vec3{q.x / h.x, q.y / h.y, q.z / h.z});
      return (k - 1) * std::min({h.x, h.y, h.z});
    }
    case SupportKind::half_space: return q.z;
    case SupportKind::hull: break;
  }
  if (s.hull->dimension < 2) {
    const Vec3 e = s.hull->vertices.back() - s.hull->vertices.front(), d = q - s.hull->vertices.front();
    const double t = dot(e, e) > 0 ? std::clamp(dot(d, e) / dot(e, e), 0.0, 1.0) : 0;
    return norm(d - e * t);
  }
  double worst = -1e300;
  for (int f = 0; f < s.hull->faces(); ++f)
    worst = std::max(worst, dot(s.hull->normals[static_cast<std::size_t>(f)], q) - s.hull->offsets[static_cast<std::size_t>(f)]);
  if (s.hull->dimension == 2)
    for (std::size_t k = 0; k < s.hull->face(0).size(); ++k) {
      const auto ring = s.hull->face(0);
      const Vec3 u = s.hull->vertices[static_cast<std::size_t>(ring[k])],
                 v = s.hull->vertices[static_cast<std::size_t>(ring[(k + 1) % ring.size()])];
      worst = std::max(worst, dot(normalized(cross(v - u, s.hull->normals[0])), q - u));
    }
  return worst;
}

inline double size_of(const Support& s) { return s.kind == SupportKind::half_space ? 0 : bounding_radius(s); }

/// Error [m] of a claimed distance between two convex shapes. The distance is proved if pa and pb are points of the shapes and a slab with
/// normal n between the shapes is as thick as the distance between pa and pb. Returns the maximum violation of these conditions.
inline double certificate(const Support& a, const Pose& A, const Support& b, const Pose& B, double distance, const Vec3& pa, const Vec3& pb,
                          const Vec3& n) {
  const double core = distance + a.radius + b.radius;
  const Vec3 qa = pa + n * a.radius, qb = pb - n * b.radius;
  const double apart = -reach(a, A, -n) - reach(b, B, n);
  return std::max({outside(a, A, qa), outside(b, B, qb), norm(qa - qb - n * core), std::fabs(apart - core), std::fabs(norm(n) - 1)});
}

inline Hull hull_of(const std::vector<Vec3>& points) {
  Result<Hull> h = geometry::make_hull(points);
  EXPECT_TRUE(h.has_value()) << (h ? "" : h.error().text());
  return h ? std::move(*h) : Hull{};
}

/// n random points on an ellipsoid with the given semi-axes.
inline std::vector<Vec3> on_ellipsoid(Random& random, int n, const Vec3& axes) {
  std::vector<Vec3> points;
  for (int i = 0; i < n; ++i) {
    const Vec3 u = random.unit();
    points.push_back({axes.x * u.x, axes.y * u.y, axes.z * u.z});
  }
  return points;
}

/// Hulls for random_support(): round hulls with 4 ... 400 vertices, a plate of thickness 1e-4, a needle, a flat hull and a segment.
inline std::vector<Hull> some_hulls(Random& random) {
  std::vector<Hull> hulls;
  for (const int n : {4, 5, 8, 12, 17, 40, 120, 400}) hulls.push_back(hull_of(on_ellipsoid(random, n, {0.5, 0.4, 0.3})));
  hulls.push_back(hull_of(on_ellipsoid(random, 30, {0.5, 0.5, 1e-4})));
  hulls.push_back(hull_of(on_ellipsoid(random, 30, {0.5, 1e-4, 1e-4})));
  std::vector<Vec3> flat = on_ellipsoid(random, 30, {0.5, 0.4, 0});
  hulls.push_back(hull_of(flat));
  hulls.push_back(hull_of({{0, 0, -0.5}, {0, 0, 0.1}, {0, 0, 0.5}, {0, 0, 0.2}}));
  return hulls;
}

/// A random bounded support; hulls are chosen from `hulls`.
/// @param polytope only spheres, capsules, boxes and hulls
inline Support random_support(Random& random, const std::vector<Hull>& hulls, bool polytope = false) {
  switch (random.below(polytope ? 5 : 7)) {
    case 0: return Support::sphere(random.in(0.05, 0.4));
    case 1: return Support::capsule(random.in(0.05, 0.3), random.in(0.05, 0.6));
    case 2:
      return Support::box({random.in(0.05, 0.5), random.in(0.05, 0.5), random.in(0.05, 0.5)}, random.below(3) == 0 ? random.in(0, 0.1) : 0);
    case 3:
    case 4:
      return Support::of(hulls[static_cast<std::size_t>(random.below(static_cast<int>(hulls.size())))], random.below(4) == 0 ? 0.02 : 0);
    case 5: return Support::cylinder(random.in(0.05, 0.5), random.in(0.02, 0.5));
    default: return Support::ellipsoid({random.in(0.05, 0.5), random.in(0.05, 0.5), random.in(0.05, 0.5)});
  }
}

}  // namespace ugoki::collision::test
