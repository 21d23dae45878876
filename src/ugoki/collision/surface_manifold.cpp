#include "ugoki/collision/surface_manifold.h"

#include <algorithm>

#include "ugoki/collision/clipping.h"
#include "ugoki/collision/core.h"

namespace ugoki::collision {
namespace {

constexpr std::size_t max_points = 4096, max_pairs = 2048;  // limits of memory and time for one pair of shapes
/// Penetration depth, as a fraction of the shape's thickness, above which the core is tested too (add_contact_of_core()).
constexpr double deep_penetration = 0.02;
/// Cosine of 1.1 degrees: a contact is a face contact if its normal is within this angle of the triangle's normal.
constexpr double face_cosine = 0.9998;

/// Sets the flat hull to the triangle f.
void set_triangle(Hull& hull, const Surface::Facet& f) {
  for (std::size_t k = 0; k < 3; ++k) hull.vertices[k] = f.p[k];
  hull.normals[0] = f.n;
  hull.normals[1] = -f.n;
  hull.offsets[0] = dot(f.n, f.p[0]);
  hull.offsets[1] = -hull.offsets[0];
  hull.centre = (f.p[0] + f.p[1] + f.p[2]) / 3;
  hull.radius = 0;
  for (const Vec3& p : f.p) hull.radius = std::max(hull.radius, norm(p - hull.centre));
}

/// Axis-aligned box around the collider at pose X, enlarged by `margin` [m].
Bounds box_at(const Collider& a, const Pose& X, double margin) {
  Bounds b;
  const Vec3 centre = X * a.centre;
  for (int i = 0; i < 3; ++i) {
    const Vec3 r = X.R.row(i);
    const double reach = a.half.x * std::fabs(r.x) + a.half.y * std::fabs(r.y) + a.half.z * std::fabs(r.z) + margin;
    b.low[i] = centre[i] - reach;
    b.high[i] = centre[i] + reach;
  }
  return b;
}

Patch patch_of(const Surface::Facet& f) {
  Patch out;
  for (std::uint32_t k = 0; k < 3; ++k) out.add(f.p[k], k);
  out.normal = f.n;
  out.face = static_cast<std::uint32_t>(f.index);
  return out;
}

/// Collects contact points between a convex shape or triangle `a` and the facets of a surface, in the surface's frame.
struct Collector {
  double margin;
  std::vector<ManifoldPoint>& points;

  void add(const Vec3& p, const Vec3& n, double distance, std::uint32_t feature) {
    if (distance < margin && points.size() < max_points) points.push_back({p, n, distance, feature});
  }

  /// Clips the patch of `a` that faces the facet f to f, and adds its corners. @return minimum height [m] of the clipped corners above f
  double add_clipped(const Patch& patch, const Surface::Facet& f, const Vec3& n, double margin_of_face) {
    Candidates cut_points;
    cut(patch_of(f), patch, n, 7, cut_points);
    for (int i = 0; i < cut_points.count; ++i) {
      const Candidate& c = cut_points.at(i);
      if (c.h < margin_of_face) add(c.p - n * (0.5 * c.h), n, c.h, c.feature);
    }
    return min_height(cut_points);
  }
};

/// Transforms the points by the pose X and, if `flip`, reverses their normals.
void transform_points(std::vector<ManifoldPoint>& points, const Pose& X, bool flip) {
  for (ManifoldPoint& p : points) {
    p.p = X * p.p;
    p.n = X.R * (flip ? -p.n : p.n);
  }
}

}  // namespace

ManifoldWorkspace::ManifoldWorkspace() {
  triangle.dimension = 2;
  triangle.vertices.resize(3);
  triangle.first_corner = {0, 3, 6};
  triangle.corners = {0, 1, 2, 0, 2, 1};
  triangle.normals.resize(2);
  triangle.offsets.resize(2);
  triangle.first_neighbour = {0, 2, 4, 6};
  triangle.neighbours = {1, 2, 0, 2, 0, 1};
  pairs.resize(max_pairs);
}

namespace {

/// Fallback contact for a pair in which no triangle yields a contact. If the shapes are apart, the contact is at the closest points. If
/// the shape pierces triangles, the contact is the exit through the plane of the triangle with the smallest depth. The shortest translation
/// would be wrong for a corner that pierces a triangle near one of its sides, as it would move the corner sideways into the next triangle.
struct FallbackContact {
  ManifoldPoint apart{{}, {}, 1e300, 0}, pierced{{}, {}, -1e300, 0};
  double nearest = 1e300;  // m: minimum signed distance over the triangles

  /// Updates the contact with triangle f, whose signed distance from the shape is d.
  /// @param lowest m: point of the shape that is deepest below the plane of f
  /// @param height m: height of this point above the plane
  void update(const Surface::Facet& f, bool closed, const SignedDistance& d, const Vec3& lowest, double height) {
    const auto feature = feature_hash(11, static_cast<std::uint32_t>(f.index), 0, 0);
    nearest = std::min(nearest, d.distance);
    if (d.distance > 0) {
      if (d.distance < apart.distance && (!closed || dot(d.n, f.n) > 0)) apart = {(d.pa + d.pb) * 0.5, d.n, d.distance, feature};
    } else if (height > pierced.distance && height < 0) {
      pierced = {lowest - f.n * (0.5 * height), f.n, height, feature};
    }
  }
  void add_to(std::vector<ManifoldPoint>& points, double bias) const {
    double min_distance = 1e300;
    for (const ManifoldPoint& p : points) min_distance = std::min(min_distance, p.distance);
    if (nearest <= 0 ? min_distance > 0 : min_distance > nearest + bias) {
      const ManifoldPoint& p = nearest <= 0 ? pierced : apart;
      if (std::fabs(p.distance) < 1e300) points.push_back(p);
    }
  }
};

/// Adds a contact at the surface point closest to the core of the shape (core.h), unless a collected contact is as deep. For deep
/// penetration the core gives a reliable depth, and single triangles do not. The core is on the correct side of a wall that is thinner than
/// the shape.
void add_contact_of_core(const Collider& a, const Pose& X_WS, const Collider& b, const Pose& X_WT, double bias, ManifoldWorkspace& work) {
  ConvexMeshCache cache;
  const BubbleDistance d =
      find_distance(a.core->collider.support, X_WS, b.prepared->spheres, X_WT, cache, work.of_core, {.farthest = a.core->depth});
  if (d.status != BubbleStatus::separated) return;
  const double depth = d.distance - a.core->depth;
  for (const ManifoldPoint& p : work.points)
    if (p.distance < depth + bias) return;
  const Vec3 n = transpose_times(X_WT.R, d.n);
  work.points.push_back(
      {X_WT.inverse() * d.pb - n * (0.5 * depth), n, depth, feature_hash(19, static_cast<std::uint32_t>(d.nearest.b), 0, 0)});
}

}  // namespace

void add_convex_surface(const Collider& a, const Pose& X_WS, const Collider& b, const Pose& X_WT, double margin, bool flip,
                        ManifoldWorkspace& work, Manifold& out) {
  const Pose X = X_WT.inverse() * X_WS;  // pose of a in the surface's frame
  const Surface surface(b);
  const bool closed = surface.closed();
  work.triangles.clear();
  work.points.clear();
  surface.collect(box_at(a, X, std::max(margin, 0.0)), work.stack, work.triangles);
  Collector found{margin, work.points};
  const Support triangle = Support::of(work.triangle);
  GilbertOptions options;
  options.farthest = margin;
  std::int32_t hint = 0;
  const double bias = 1e-4 * a.thickness;
  FallbackContact fallback;
  for (const std::int32_t t : work.triangles) {
    const Surface::Facet f = surface.facet(t);
    const SupportPoint low = find_support(a.support, transpose_times(X.R, -f.n), hint);
    hint = low.vertex;
    const double height = dot(f.n, X * low.p - f.p[0]) - a.support.radius;
    if (!(height < margin)) continue;
    set_triangle(work.triangle, f);
    GilbertCache cache;
    const SignedDistance d = signed_distance(a.support, X, triangle, Pose{}, cache, work.penetration, options);
    if (d.status == DistanceStatus::beyond || d.status == DistanceStatus::not_finite || !(d.distance < margin)) continue;
    const double along = dot(d.n, f.n);
    fallback.update(f, closed, d, X * low.p - f.n * a.support.radius, height);
    // A shape behind a triangle of a closed surface is pushed back out through the triangle, unless the whole shape is behind it.
    const bool behind = closed && along < -face_cosine && d.distance < 0 && height > -2 * a.thickness;
    const bool flat = along > face_cosine || (!closed && along < -face_cosine);
    const bool touches = !behind && touches_from(surface, f, d.pb, d.n);
    if (!touches && !flat && !behind) continue;
    double face_height = 1e300;
    if (flat || behind) {
      const Vec3 face = along < 0 && !closed ? -f.n : f.n;
      Patch patch;
      find_patch(a, X, -face, hint, patch);
      if (patch.count > 1) face_height = found.add_clipped(patch, f, face, margin);
    }
    if (touches && face_height > d.distance + bias)
      found.add((d.pa + d.pb) * 0.5, d.n, d.distance, feature_hash(11, static_cast<std::uint32_t>(t), 0, 0));
  }
  fallback.add_to(work.points, bias);
  if (fallback.nearest < -deep_penetration * a.thickness && a.core != nullptr && b.prepared)
    add_contact_of_core(a, X_WS, b, X_WT, bias, work);
  transform_points(work.points, X_WT, flip);
  add_spanning(work.points, bias, out);
}

void add_surface_surface(const Collider& a, const Pose& X_WS, const Collider& b, const Pose& X_WT, double margin, ManifoldWorkspace& work,
                         Manifold& out) {
  work.points.clear();
  if (!a.prepared || !b.prepared) return;
  const Surface on_a(a), on_b(b);
  const PairsFound pairs = find_pairs_within(a.prepared->spheres, X_WS, b.prepared->spheres, X_WT, margin, work.pairs, work.bubble);
  const Pose X = X_WT.inverse() * X_WS;
  Collector found{margin, work.points};
  const double bias = 1e-4 * std::min(a.thickness, b.thickness);
  for (std::size_t i = 0; i < pairs.count; ++i) {
    const TriangleContact& c = work.pairs[i];
    const Surface::Facet fb = on_b.facet(c.pair.b), local = on_a.facet(c.pair.a);
    Surface::Facet fa = local;  // triangle of a in b's frame
    for (Vec3& p : fa.p) p = X * p;
    fa.n = X.R * fa.n;
    const std::uint32_t feature = feature_hash(13, static_cast<std::uint32_t>(c.pair.a), static_cast<std::uint32_t>(c.pair.b), 0);
    const auto depth = [](const Surface::Facet& above, const Surface::Facet& below) {
      double min_height = 1e300;
      for (const Vec3& p : above.p) min_height = std::min(min_height, dot(below.n, p - below.p[0]));
      return min_height;
    };
    if (c.distance > 1e-12 * (a.bound + b.bound)) {
      const Vec3 pa = transpose_times(X_WT.R, c.pa - X_WT.p), pb = transpose_times(X_WT.R, c.pb - X_WT.p);
      const Vec3 n = (pa - pb) / c.distance;
      if (!touches_from(on_b, fb, pb, n) || !touches_from(on_a, local, X.inverse() * pa, transpose_times(X.R, -n))) continue;
      double face_height = 1e300;
      if (dot(n, fb.n) > face_cosine && dot(n, fa.n) < -face_cosine) face_height = found.add_clipped(patch_of(fa), fb, fb.n, margin);
      if (face_height > c.distance + bias) found.add((pa + pb) * 0.5, n, c.distance, feature);
      continue;
    }
    // The triangles pierce each other: separate them along the normal of the plane that gives the smaller depth.
    const double of_a = depth(fa, fb), of_b = depth(fb, fa);
    if (of_a >= of_b) {
      found.add_clipped(patch_of(fa), fb, fb.n, 0);
    } else {
      Candidates cut_points;
      cut(patch_of(fa), patch_of(fb), fa.n, 17, cut_points);
      for (int k = 0; k < cut_points.count; ++k) {
        const Candidate& point = cut_points.at(k);
        if (point.h < 0) found.add(point.p - fa.n * (0.5 * point.h), -fa.n, point.h, point.feature);
      }
    }
  }
  transform_points(work.points, X_WT, false);
  add_spanning(work.points, bias, out);
}

void add_surface_ground(const Collider& a, const Pose& X_WS, double height, double margin, ManifoldWorkspace& work, Manifold& out) {
  work.points.clear();
  work.triangles.clear();
  const auto add = [&](const Vec3& local, std::uint32_t feature) {
    const Vec3 p = X_WS * local;
    const double distance = p.z - height;
    if (distance < margin && work.points.size() < max_points)
      work.points.push_back({{p.x, p.y, height + 0.5 * distance}, {0, 0, 1}, distance, feature});
  };
  if (const HeightField* field = a.shape.field.get()) {
    for (std::uint32_t i = 0; i < field->heights.size(); ++i)
      add(field->point(static_cast<int>(i) % field->columns, static_cast<int>(i) / field->columns), i);
    for (std::uint32_t i = 0; i < 4; ++i)
      add({(i & 1) != 0 ? field->half_x : -field->half_x, (i & 2) != 0 ? field->half_y : -field->half_y, -field->base}, 0xfffff0U + i);
  } else {
    const SphereTree& tree = a.prepared->spheres;
    for (std::uint32_t i = 0; i < tree.vertices.size(); ++i) add(tree.vertices[i] + tree.centre, i & 0xffffffU);
  }
  add_spanning(work.points, 1e-4 * a.thickness, out);
}

}  // namespace ugoki::collision
