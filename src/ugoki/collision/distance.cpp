#include "ugoki/collision/distance.h"

#include <limits>

#include "ugoki/collision/pair_distance.h"
#include "ugoki/collision/round.h"

namespace ugoki::collision {
namespace {

double copy_out(const PairDistance& d, Vec3* pa, Vec3* pb, Vec3* n) {
  if (pa != nullptr) *pa = d.pa;
  if (pb != nullptr) *pb = d.pb;
  if (n != nullptr) *n = d.n;
  return d.distance;
}

}  // namespace

double distance(const Collider& a, const Pose& X_WA, const Collider& b, const Pose& X_WB, Vec3* pa, Vec3* pb, Vec3* n) {
  PairCache cache;
  DistanceWorkspace workspace;
  constexpr double any = std::numeric_limits<double>::infinity();
  return copy_out(find_pair_distance(a, X_WA * a.shape.X_BS, b, X_WB * b.shape.X_BS, any, cache, workspace), pa, pb, n);
}

double distance(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB, Vec3* pa, Vec3* pb, Vec3* n) {
  if (has_closed_form(a.type) && has_closed_form(b.type))
    return copy_out(closed_form_distance(a, X_WA * a.X_BS, b, X_WB * b.X_BS), pa, pb, n);
  return distance(make_collider(a), X_WA, make_collider(b), X_WB, pa, pb, n);
}

double distance_to_ground(const Shape& a, const Pose& X_WA, double height, Vec3* pa) {
  const Pose X = X_WA * a.X_BS;
  Vec3 lowest = X.p;
  if (!has_closed_form(a.type)) {
    lowest.z -= reach(a, -X.R.row(2));
    if (pa != nullptr && a.type != ShapeType::height_field) {
      const Collider c = make_collider(a);
      if (c.convex || c.support.hull != nullptr) *pa = X * find_support(c.support, -X.R.row(2)).p;
    }
    return lowest.z - height;
  }
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
