#include "ugoki/collision/gilbert.h"

#include "ugoki/collision/gilbert_width.h"
#include "ugoki/collision/hull_leap.h"

namespace ugoki::collision {
namespace {

/// Distance between two shapes in closed form, if one of them is a half-space.
GilbertResult half_space_distance(const Support& a, const Pose& X_WA, const Support& b, const Pose& X_WB) {
  GilbertResult out;
  const bool first = a.kind == SupportKind::half_space;
  if (first && b.kind == SupportKind::half_space) {
    out.status = GilbertStatus::not_bounded;
    return out;
  }
  const Pose &X_plane = first ? X_WA : X_WB, &X = first ? X_WB : X_WA;
  const Support& s = first ? b : a;
  const Vec3 up = X_plane.R.column(2);
  const Vec3 lowest = X * support_point(s, transpose_times(X.R, -up), 0).p;
  const double height = dot(up, lowest - X_plane.p);
  out.distance = out.lower = height - a.radius - b.radius;
  if (!(out.distance - out.distance == 0)) return out;
  out.status = height > 0 ? GilbertStatus::separated : GilbertStatus::touching;
  out.iterations = 1;
  const Vec3 near = lowest - up * s.radius, foot = near - up * out.distance;
  out.n = first ? -up : up;
  out.pa = first ? foot : near;
  out.pb = first ? near : foot;
  return out;
}

#ifdef UGOKI_X86_WIDTHS
bool has_avx2() { return __builtin_cpu_supports("avx2") != 0; }
bool has_avx512() { return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq"); }
GilbertWidth width_in_use = has_avx512() ? GilbertWidth::avx512 : has_avx2() ? GilbertWidth::avx2 : GilbertWidth::plain;
#endif

bool is_empty(const Support& s) { return s.kind == SupportKind::hull && (s.hull == nullptr || s.hull->vertices.empty()); }
/// True for hulls on which hill climbing is prepared (Hull::walk).
bool has_walk(const Support& s) { return s.kind == SupportKind::hull && !s.hull->walk.nodes.empty(); }

}  // namespace

bool use_gilbert_width(GilbertWidth width) {
#ifdef UGOKI_X86_WIDTHS
  if ((width == GilbertWidth::avx512 && !has_avx512()) || (width == GilbertWidth::avx2 && !has_avx2())) return false;
  width_in_use = width;
  return true;
#else
  return width == GilbertWidth::plain;
#endif
}

GilbertResult gilbert_distance(const Support& a, const Pose& X_WA, const Support& b, const Pose& X_WB, GilbertCache& cache,
                               const GilbertOptions& options) {
  if (is_empty(a) || is_empty(b)) return {};
  if (has_walk(a) && has_walk(b)) {
#ifdef UGOKI_X86_WIDTHS
    if (width_in_use == GilbertWidth::avx512) return hull_distance_avx512(a, X_WA, b, X_WB, cache, options);
    if (width_in_use == GilbertWidth::avx2) return hull_distance_avx2(a, X_WA, b, X_WB, cache, options);
#endif
    return hull_distance(a, X_WA, b, X_WB, cache, options);
  }
  if (!all_finite(X_WA) || !all_finite(X_WB)) return {};
  if (a.kind == SupportKind::half_space || b.kind == SupportKind::half_space) return half_space_distance(a, X_WA, b, X_WB);
  return Search<AnyCore, AnyCore>(a, X_WA, b, X_WB, cache, options).run();
}

}  // namespace ugoki::collision
