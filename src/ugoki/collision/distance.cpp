#include "ugoki/collision/distance.h"

#include <algorithm>

#include "ugoki/collision/box_box.h"
#include "ugoki/collision/round_pair.h"
#include "ugoki/collision/segment_box.h"

namespace ugoki::collision {
namespace {

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

}  // namespace

double bounding_radius(const Shape& s) {
  switch (s.type) {
    case ShapeType::sphere: return s.radius;
    case ShapeType::capsule: return s.radius + s.half_length;
    case ShapeType::box: return norm(s.half_extents);
    case ShapeType::cylinder: return std::sqrt(s.radius * s.radius + s.half_length * s.half_length);
    case ShapeType::ellipsoid: return std::max({s.half_extents.x, s.half_extents.y, s.half_extents.z});
    case ShapeType::mesh: {
      double most = 0;
      for (const Vec3& p : s.geometry->vertices) most = std::max(most, dot(p, p));
      return std::sqrt(most);
    }
    case ShapeType::height_field: {
      const Bounds b = bounds(s);
      return norm(Vec3{b.high.x, b.high.y, std::max(std::fabs(b.low.z), std::fabs(b.high.z))});
    }
  }
  return 0;
}

double distance(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB, Vec3* pa, Vec3* pb, Vec3* n) {
  const Pose X_a = X_WA * a.X_BS, X_b = X_WB * b.X_BS;
  const bool box_a = a.type == ShapeType::box, box_b = b.type == ShapeType::box;
  BoxPair pair;
  if (box_a && box_b) {
    pair = nearest_on_boxes({X_a, a.half_extents}, {X_b, b.half_extents});
  } else if (box_b) {
    pair = nearest_round_box(make_round(a, X_a), {X_b, b.half_extents});
  } else if (box_a) {
    const BoxPair mirrored = nearest_round_box(make_round(b, X_b), {X_a, a.half_extents});
    pair = {mirrored.pb, mirrored.pa, -mirrored.n, mirrored.distance};
  } else {
    const Round ra = make_round(a, X_a), rb = make_round(b, X_b);
    const SegmentPair near = nearest_on_segments(ra, rb);
    const RoundPair round = round_pair_at(ra, rb, near.s, near.t, near.sin2);
    pair = {round.pa, round.pb, round.n, round.distance};
  }
  if (pa != nullptr) *pa = pair.pa;
  if (pb != nullptr) *pb = pair.pb;
  if (n != nullptr) *n = pair.n;
  return pair.distance;
}

double distance_to_ground(const Shape& a, const Pose& X_WA, double height, Vec3* pa) {
  const Pose X = X_WA * a.X_BS;
  Vec3 lowest = X.p;
  if (a.type > ShapeType::box) return X.p.z - reach(a, -X.R.row(2)) - height;
  if (a.type == ShapeType::box) {
    for (int i = 0; i < 3; ++i) {
      const Vec3 axis = X.R.column(i);
      lowest += axis * (axis.z > 0 ? -a.half_extents[i] : a.half_extents[i]);
    }
  } else {
    const Round r = make_round(a, X);
    lowest = r.at(r.d.z > 0 ? -r.half : r.half) - Vec3{0, 0, r.radius};
  }
  if (pa != nullptr) *pa = lowest;
  return lowest.z - height;
}

}  // namespace ugoki::collision
