#include "ugoki/collision/manifold.h"

#include <algorithm>

#include "ugoki/collision/box_box.h"
#include "ugoki/collision/round_pair.h"
#include "ugoki/collision/segment_box.h"

namespace ugoki::collision {
namespace {

// sin^2 of 10 degrees: a segment within this angle of another segment or of a box face has two contact points with it, otherwise one.
constexpr double parallel_sin2 = 0.03;
// Parallel segments have one contact point if they overlap by less than this fraction of the shorter half length.
constexpr double min_overlap = 0.01;

void add_round_round(const Round& a, const Round& b, double margin, Manifold& out) {
  const SegmentPair nearest = nearest_on_segments(a, b);
  const Vec3 gap = a.at(nearest.s) - b.at(nearest.t);
  const double reach = a.radius + b.radius + margin;
  if (reach <= 0 || !(dot(gap, gap) < reach * reach)) return;

  const RoundPair deepest = round_pair_at(a, b, nearest.s, nearest.t, nearest.sin2);
  const auto add = [&](const RoundPair& pair, std::uint32_t feature) {
    if (pair.distance < margin) out.add((pair.pa + pair.pb) * 0.5, pair.n, pair.distance, feature);
  };
  double low = 0, high = 0;
  const bool side_by_side = a.half > 0 && b.half > 0 && nearest.sin2 < parallel_sin2 && overlap_on(a, b, low, high) &&
                            high - low > min_overlap * std::min(a.half, b.half);
  if (!side_by_side) return add(deepest, 0);

  // Normally the contact points are the two ends of the overlap. If the deepest point is between the ends, it replaces the nearer end.
  const auto end = [&](double s) { return round_pair_at(a, b, s, clamp_to(dot(b.d, a.at(s) - b.c), b.half), nearest.sin2); };
  const RoundPair first = end(low), second = end(high);
  if (std::min(first.distance, second.distance) <= deepest.distance + 1e-6 * (a.radius + b.radius)) {
    add(first, 1);
    add(second, 2);
  } else {
    add(deepest, 0);
    if (nearest.s - low > high - nearest.s)
      add(first, 1);
    else
      add(second, 2);
  }
}

/// Contact points of a sphere or capsule and a box. The normals point from the box to the round shape; if `flip`, from the round shape to
/// the box.
void add_round_box(const Round& world, const Box& box, bool flip, double margin, Manifold& out) {
  const Round s = in_box(world, box.X);
  const SegmentBox nearest = nearest_on_segment_and_box(s, box.e);
  if (!(nearest.distance - s.radius < margin)) return;

  const auto add = [&](double t, const Vec3& n, double distance, std::uint32_t feature) {
    if (!(distance < margin)) return;
    const Vec3 n_world = box.X.R * n;
    out.add(box.X * (s.at(t) - n * (s.radius + 0.5 * distance)), flip ? -n_world : n_world, distance, feature);
  };
  const double along = dot(nearest.n, s.d);
  double low = -s.half, high = s.half;
  bool parallel = s.half > 0 && nearest.edge < 0 && along * along < parallel_sin2;
  // For a segment parallel to a face or an edge: clip the segment to the box along the axes of that face or edge.
  for (int i = 0; i < 3 && parallel; ++i)
    if (std::fabs(nearest.n[i]) < 0.1) parallel = cut_to_slab(s, box.e, i, low, high);
  parallel = parallel && high - low > min_overlap * s.half;
  if (!parallel) return add(nearest.t, nearest.n, nearest.distance - s.radius, 0);

  struct End {
    Vec3 n;
    double distance;
  };
  const auto end = [&](double t) -> End {
    const Vec3 p = s.at(t);
    const Vec3 gap = p - clamp_to(p, box.e);
    const double d = norm(gap);
    if (d > 1e-9 * (box.e.x + box.e.y + box.e.z)) return {gap / d, d - s.radius};
    const Vec3& n = nearest.n;  // the end is inside the box: use the face through which the whole segment leaves it
    return {n, dot(p, n) - (box.e.x * std::fabs(n.x) + box.e.y * std::fabs(n.y) + box.e.z * std::fabs(n.z)) - s.radius};
  };
  const End first = end(low), second = end(high);
  const double deepest = nearest.distance - s.radius;
  if (std::min(first.distance, second.distance) <= deepest + 1e-6 * s.radius) {
    add(low, first.n, first.distance, 1);
    add(high, second.n, second.distance, 2);
  } else {
    add(nearest.t, nearest.n, deepest, 0);
    if (nearest.t - low > high - nearest.t)
      add(low, first.n, first.distance, 1);
    else
      add(high, second.n, second.distance, 2);
  }
}

}  // namespace

void find_manifold(const Shape& a, const Pose& X_WS, const Shape& b, const Pose& X_WT, double margin, Manifold& out) {
  out.count = 0;
  if (!is_simple(a.type) || !is_simple(b.type)) return;
  const bool box_a = a.type == ShapeType::box, box_b = b.type == ShapeType::box;
  if (box_a && box_b) return add_box_box({X_WS, a.half_extents}, {X_WT, b.half_extents}, margin, out);
  if (box_b) return add_round_box(make_round(a, X_WS), {X_WT, b.half_extents}, false, margin, out);
  if (box_a) return add_round_box(make_round(b, X_WT), {X_WS, a.half_extents}, true, margin, out);
  add_round_round(make_round(a, X_WS), make_round(b, X_WT), margin, out);
}

void find_ground_manifold(const Shape& a, const Pose& X, double height, double margin, Manifold& out) {
  out.count = 0;
  constexpr Vec3 up{0, 0, 1};
  const auto add = [&](const Vec3& lowest, std::uint32_t feature) {
    const double distance = lowest.z - height;
    if (distance < margin) out.add({lowest.x, lowest.y, height + 0.5 * distance}, up, distance, feature);
  };
  switch (a.type) {
    case ShapeType::sphere: add(X.p - up * a.radius, 0); return;
    case ShapeType::capsule: {
      const Vec3 reach = X.R.column(2) * a.half_length;
      add(X.p - reach - up * a.radius, 0);
      if (a.half_length > 0) add(X.p + reach - up * a.radius, 1);
      return;
    }
    case ShapeType::box: {
      const Vec3 x = X.R.column(0) * a.half_extents.x, y = X.R.column(1) * a.half_extents.y, z = X.R.column(2) * a.half_extents.z;
      for (std::uint32_t c = 0; c < 8; ++c) add(X.p + ((c & 1) != 0 ? x : -x) + ((c & 2) != 0 ? y : -y) + ((c & 4) != 0 ? z : -z), c);
      return;
    }
    case ShapeType::cylinder:
    case ShapeType::ellipsoid:
    case ShapeType::mesh:
    case ShapeType::height_field: return;
  }
}

}  // namespace ugoki::collision
