#include "ugoki/collision/contact_manifold.h"

#include "ugoki/collision/convex_manifold.h"

namespace ugoki::collision {
namespace {

bool has_hull(const Collider& c) { return c.convex || (c.support.hull != nullptr && !c.support.hull->vertices.empty()); }

}  // namespace

void find_manifold(const Collider& a, const Pose& X_WS, const Collider& b, const Pose& X_WT, double margin, GilbertCache& cache,
                   ManifoldWorkspace& work, Manifold& out) {
  if (is_simple(a.shape.type) && is_simple(b.shape.type)) return find_manifold(a.shape, X_WS, b.shape, X_WT, margin, out);
  out.count = 0;
  if (a.convex && b.convex) return add_convex_convex(a, X_WS, b, X_WT, margin, cache, work.penetration, out);
  if (a.convex) return add_convex_surface(a, X_WS, b, X_WT, margin, false, work, out);
  if (b.convex) return add_convex_surface(b, X_WT, a, X_WS, margin, true, work, out);
  const bool field_a = a.shape.type == ShapeType::height_field, field_b = b.shape.type == ShapeType::height_field;
  if (!field_a && !field_b) return add_surface_surface(a, X_WS, b, X_WT, margin, work, out);
  if (!field_a && has_hull(a)) return add_convex_surface(a, X_WS, b, X_WT, margin, false, work, out);
  if (!field_b && has_hull(b)) return add_convex_surface(b, X_WT, a, X_WS, margin, true, work, out);
}

void find_ground_manifold(const Collider& a, const Pose& X_WS, double height, double margin, std::int32_t& hint, ManifoldWorkspace& work,
                          Manifold& out) {
  if (is_simple(a.shape.type)) return find_ground_manifold(a.shape, X_WS, height, margin, out);
  out.count = 0;
  if (a.convex) return add_convex_ground(a, X_WS, height, margin, hint, work.points, out);
  add_surface_ground(a, X_WS, height, margin, work, out);
}

}  // namespace ugoki::collision
