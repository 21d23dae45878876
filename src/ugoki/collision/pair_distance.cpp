#include "ugoki/collision/pair_distance.h"

#include <algorithm>
#include <utility>

#include "ugoki/collision/box_box.h"
#include "ugoki/collision/mesh_point.h"
#include "ugoki/collision/round_pair.h"
#include "ugoki/collision/segment_box.h"

namespace ugoki::collision {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
// Fractions of the smaller bounding radius, for the choice between convex hulls and triangles:
constexpr double hysteresis = 0.02;  // extra distance between the hulls before queries start with the hulls again
constexpr double far_apart = 0.25;   // upper limit of the cutoff, so that even with an infinite cutoff queries return to the hulls

BoxPair nearest_round_box(const Round& round, const Box& box) {
  const Round s = in_box(round, box.X);
  const SegmentBox near = nearest_on_segment_and_box(s, box.e);
  BoxPair out;
  out.n = box.X.R * near.n;
  out.distance = near.distance - round.radius;
  out.pb = box.X * near.on_box;
  out.pa = out.pb + out.n * out.distance;
  return out;
}

Support core_of(const Shape& s) {
  if (s.type == ShapeType::box) return Support::box(s.half_extents);
  return s.type == ShapeType::capsule ? Support::capsule(s.radius, s.half_length) : Support::sphere(s.radius);
}

/// Replaces the closed-form distance d by the result of Gilbert's method if d is inaccurate and that result is more accurate. The closed
/// forms lose digits for edges that are almost parallel and almost touch. The error of d is bounded by the gap between the distance and the
/// lower bound that the direction d.n proves.
void certify(const Shape& a, const Pose& X_WS, const Shape& b, const Pose& X_WT, PairDistance& d) {
  const Support sa = core_of(a), sb = core_of(b);
  const Vec3 low = X_WS * find_support(sa, transpose_times(X_WS.R, -d.n)).p, high = X_WT * find_support(sb, transpose_times(X_WT.R, d.n)).p;
  const double sizes = bounding_radius(sa) + bounding_radius(sb), lower = dot(d.n, low - high) - sa.radius - sb.radius;
  if (!(d.distance - lower > 2e-10 * sizes + 4e-15 * norm(X_WS.p - X_WT.p))) return;
  GilbertCache cache;
  const GilbertResult g = gilbert_distance(sa, X_WS, sb, X_WT, cache);
  if (g.status == GilbertStatus::separated && g.distance - g.lower < d.distance - lower)
    d = {g.distance, std::min(g.lower, g.distance), g.pa, g.pb, g.n, true, DistanceMethod::gilbert};
}

PairDistance unknown() {
  PairDistance out;
  out.distance = infinity;
  out.lower = -infinity;
  return out;
}

PairDistance of_convex(const Collider& a, const Pose& X_WS, const Collider& b, const Pose& X_WT, double cutoff, PairCache& cache,
                       DistanceWorkspace& workspace) {
  const GilbertOptions options{.farthest = cutoff};
  const GilbertResult g = gilbert_distance(a.support, X_WS, b.support, X_WT, cache.gilbert, options);
  if (g.status == GilbertStatus::separated)
    return {g.distance, std::min(g.lower, g.distance), g.pa, g.pb, g.n, true, DistanceMethod::gilbert};
  if (g.status == GilbertStatus::beyond) return {g.distance, g.lower, g.pa, g.pb, g.n, false, DistanceMethod::gilbert};
  const SignedDistance d = signed_distance(a.support, X_WS, b.support, X_WT, cache.gilbert, workspace.penetration, options);
  if (d.status == DistanceStatus::not_finite || d.status == DistanceStatus::not_bounded) return unknown();
  return {d.distance, std::min(d.lower, d.distance), d.pa, d.pb, d.n, d.status != DistanceStatus::beyond, DistanceMethod::gilbert};
}

/// True if the closest point that was found on the support (hull) is a point of the shape. This is always so for a convex shape. For the
/// hull of a non-convex shape it requires that the closest feature is a single vertex.
bool on_shape(const Collider& c, const std::array<std::int32_t, 3>& vertices, int count) {
  if (c.convex) return true;
  return count > 0 && std::all_of(vertices.begin(), vertices.begin() + count, [&](std::int32_t v) { return v == vertices[0]; });
}

/// Distance between the convex hulls of two shapes; `lower` = -infinity if a hull is not known or the hulls overlap.
PairDistance of_hulls(const Collider& a, const Pose& X_WS, const Collider& b, const Pose& X_WT, double cutoff, PairCache& cache) {
  const auto known = [](const Collider& c) { return c.convex || (c.support.hull != nullptr && !c.support.hull->vertices.empty()); };
  if (!known(a) || !known(b)) return unknown();
  const GilbertResult h = gilbert_distance(a.support, X_WS, b.support, X_WT, cache.gilbert, {.farthest = cutoff});
  if (h.status != GilbertStatus::separated && h.status != GilbertStatus::beyond) return unknown();
  const bool exact = h.status == GilbertStatus::separated && h.lower > 0 && on_shape(a, cache.gilbert.a, cache.gilbert.count) &&
                     on_shape(b, cache.gilbert.b, cache.gilbert.count);
  return {h.distance, std::min(h.lower, h.distance), h.pa, h.pb, h.n, exact, DistanceMethod::hulls};
}

/// Exchanges the bodies a and b in the result d.
BubbleDistance swapped(BubbleDistance d) {
  std::swap(d.pa, d.pb);
  d.n = -d.n;
  return d;
}

PairDistance of_surfaces(const Collider& a, const Pose& X_WS, const Collider& b, const Pose& X_WT, double cutoff, PairCache& cache,
                         DistanceWorkspace& workspace) {
  if ((!a.convex && !a.prepared) || (!b.convex && !b.prepared)) return unknown();
  const BubbleOptions options{.farthest = cutoff};
  BubbleDistance d;
  if (a.convex)
    d = find_distance(a.support, X_WS, b.prepared->spheres, X_WT, cache.convex_mesh, workspace.convex_mesh, options);
  else if (b.convex)
    d = swapped(find_distance(b.support, X_WT, a.prepared->spheres, X_WS, cache.convex_mesh, workspace.convex_mesh, options));
  else
    d = find_distance(a.prepared->spheres, X_WS, b.prepared->spheres, X_WT, cache.triangles, workspace.bubble, options);
  if (d.status == BubbleStatus::not_finite) return unknown();
  PairDistance out{d.distance, std::min(d.lower, d.distance), d.pa, d.pb, d.n, d.status != BubbleStatus::beyond, DistanceMethod::bubble};
  if (d.status != BubbleStatus::touching || a.convex || b.convex) return out;
  const MeshPenetration penetration = find_penetration(a.prepared->spheres, X_WS, b.prepared->spheres, X_WT, workspace.bubble);
  if (penetration.status != PenetrationStatus::penetrating) return out;
  return {-penetration.depth, -penetration.depth, penetration.pa, penetration.pb, penetration.n, true, DistanceMethod::bubble};
}

}  // namespace

PairDistance closed_form_distance(const Shape& a, const Pose& X_WS, const Shape& b, const Pose& X_WT) {
  const bool box_a = a.type == ShapeType::box, box_b = b.type == ShapeType::box;
  BoxPair pair;
  if (box_a && box_b) {
    pair = nearest_on_boxes({X_WS, a.half_extents}, {X_WT, b.half_extents});
  } else if (box_b) {
    pair = nearest_round_box(make_round(a, X_WS), {X_WT, b.half_extents});
  } else if (box_a) {
    const BoxPair mirrored = nearest_round_box(make_round(b, X_WT), {X_WS, a.half_extents});
    pair = {mirrored.pb, mirrored.pa, -mirrored.n, mirrored.distance};
  } else {
    const Round ra = make_round(a, X_WS), rb = make_round(b, X_WT);
    const SegmentPair near = nearest_on_segments(ra, rb);
    const RoundPair round = round_pair_at(ra, rb, near.s, near.t, near.sin2);
    pair = {round.pa, round.pb, round.n, round.distance};
  }
  PairDistance out{pair.distance, pair.distance, pair.pa, pair.pb, pair.n, true, DistanceMethod::closed_form};
  if ((box_a || box_b) && out.distance > 0) certify(a, X_WS, b, X_WT, out);
  return out;
}

PairDistance find_pair_distance(const Collider& a, const Pose& X_WS, const Collider& b, const Pose& X_WT, double cutoff, PairCache& cache,
                                DistanceWorkspace& workspace) {
  if (has_closed_form(a.shape.type) && has_closed_form(b.shape.type)) {
    const PairDistance d = closed_form_distance(a.shape, X_WS, b.shape, X_WT);
    return std::isfinite(d.distance) ? d : unknown();
  }
  // The distance of a shape from a half-space equals that of its convex hull.
  const auto plane = [](const Collider& c) { return c.support.kind == SupportKind::half_space; };
  if ((a.convex || plane(b)) && (b.convex || plane(a))) return of_convex(a, X_WS, b, X_WT, cutoff, cache, workspace);
  if (!cache.near) {
    const PairDistance hulls = of_hulls(a, X_WS, b, X_WT, cutoff, cache);
    if (hulls.exact || hulls.lower >= cutoff) return hulls;
    cache.near = true;
  }
  const PairDistance surfaces = of_surfaces(a, X_WS, b, X_WT, cutoff, cache, workspace);
  const double size = std::min(a.bound, b.bound), apart = std::min(cutoff, far_apart * size) + hysteresis * size;
  if (!(surfaces.exact && surfaces.distance <= apart)) {
    const PairDistance hulls = of_hulls(a, X_WS, b, X_WT, apart, cache);
    cache.near = !(hulls.lower > apart);
  }
  return surfaces;
}

}  // namespace ugoki::collision
