#include "ugoki/collision/patch.h"

#include <algorithm>

namespace ugoki::collision {
namespace {

constexpr double side_sine = 0.17;  // sin 10 degrees: a straight side is the patch if it is perpendicular to d within 10 degrees

/// Adds the face of a box (half extents e, pose X) whose normal is closest to the direction `local` (shape's frame).
void add_box_face(const Vec3& e, const Pose& X, const Vec3& local, Patch& out) {
  const Vec3 size{std::fabs(local.x), std::fabs(local.y), std::fabs(local.z)};
  const int w = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2, u = (w + 1) % 3, v = (w + 2) % 3;
  const double up = local[w] < 0 ? -1.0 : 1.0;
  for (std::uint32_t k = 0; k < 4; ++k) {
    const std::uint32_t i = up > 0 ? k : 3 - k;
    Vec3 corner;
    corner[w] = up * e[w];
    corner[u] = i == 1 || i == 2 ? e[u] : -e[u];
    corner[v] = i >= 2 ? e[v] : -e[v];
    const std::uint32_t label = (corner.x > 0 ? 1U : 0U) + (corner.y > 0 ? 2U : 0U) + (corner.z > 0 ? 4U : 0U);
    out.add(X * corner, label);
  }
  out.normal = X.R.column(w) * up;
  out.face = static_cast<std::uint32_t>(2 * w) + (up < 0 ? 1 : 0);
}

/// Adds one face around the hull's vertex farthest along `local` (shape's frame): that with the normal closest to `local`.
void add_hull_face(const Hull& hull, const PreparedGeometry& around, const Pose& X, const Vec3& local, std::int32_t hint, Patch& out) {
  const std::int32_t vertex = find_extreme_vertex(hull, local, hint);
  const auto v = static_cast<std::size_t>(vertex);
  int best = -1;
  double best_along = -2;
  for (std::int32_t k = around.first_face[v]; k < around.first_face[v + 1]; ++k) {
    const std::int32_t f = around.faces[static_cast<std::size_t>(k)];
    const double along = dot(hull.normals[static_cast<std::size_t>(f)], local);
    if (along > best_along) {
      best_along = along;
      best = f;
    }
  }
  if (best < 0) {  // the hull has no faces: it is a segment or a point
    for (std::size_t i = 0; i < hull.vertices.size(); ++i) out.add(X * hull.vertices[i], static_cast<std::uint32_t>(i));
    return;
  }
  const std::span<const std::int32_t> corners = hull.face(best);
  const auto at = static_cast<std::size_t>(std::find(corners.begin(), corners.end(), vertex) - corners.begin());
  const std::size_t n = corners.size(), stride = (n + Patch::max_corners - 1) / Patch::max_corners;
  for (std::size_t i = 0; i < n;
       i += stride) {  // starts at the farthest corner; of faces with more than 32 corners, only every `stride`-th corner is added
    const std::int32_t c = corners[(at + i) % n];
    out.add(X * hull.vertices[static_cast<std::size_t>(c)], static_cast<std::uint32_t>(c));
  }
  out.normal = X.R * hull.normals[static_cast<std::size_t>(best)];
  out.face = static_cast<std::uint32_t>(best);
}

/// Adds the flat end of a cylinder as an octagon of fixed rim points. If the end is tilted, adds the rim point farthest along `local` too.
void add_end(const Vec3& size, const Pose& X, const Vec3& local, Patch& out) {
  const double z = local.z < 0 ? -size.z : size.z, r = size.x, sign = local.z < 0 ? -1.0 : 1.0;
  constexpr double h = 0.7071067811865476;
  constexpr double rim[8][2] = {{1, 0}, {h, h}, {0, 1}, {-h, h}, {-1, 0}, {-h, -h}, {0, -1}, {h, -h}};
  const double radial = std::sqrt(local.x * local.x + local.y * local.y);
  const bool tilted = radial > 1e-6;
  const double cx = tilted ? local.x / radial : 1, cy = tilted ? local.y / radial * sign : 0;
  for (std::uint32_t i = 0; i < 8; ++i) {
    const double x = rim[i][0], y = rim[i][1], nx = rim[(i + 1) % 8][0], ny = rim[(i + 1) % 8][1];
    out.add(X * Vec3{r * x, sign * r * y, z}, i);
    const bool between = x * cy - y * cx > 1e-9 && cx * ny - cy * nx > 1e-9;
    if (tilted && between) out.add(X * Vec3{r * cx, sign * r * cy, z}, 8);
  }
  out.normal = X.R.column(2) * sign;
  out.face = local.z < 0 ? 1 : 0;
}

/// Adds the straight line on the side of a cylinder that is farthest along the direction `local` (shape's frame).
void add_side(const Vec3& size, const Pose& X, const Vec3& local, Patch& out) {
  const double radial = std::sqrt(local.x * local.x + local.y * local.y);
  const double x = size.x * local.x / radial, y = size.x * local.y / radial;
  out.add(X * Vec3{x, y, -size.z}, 0);
  out.add(X * Vec3{x, y, size.z}, 1);
  out.face = 2;
}

}  // namespace

void find_patch(const Collider& shape, const Pose& X, const Vec3& d, std::int32_t hint, Patch& out) {
  out.count = 0;
  out.radius = shape.support.radius;
  out.face = 0;
  const Support& s = shape.support;
  const Vec3 local = transpose_times(X.R, d);
  switch (s.kind) {
    case SupportKind::segment:
      if (std::fabs(local.z) >= side_sine) break;
      out.add(X * Vec3{0, 0, -s.size.z}, 0);
      out.add(X * Vec3{0, 0, s.size.z}, 1);
      return;
    case SupportKind::box: return add_box_face(s.size, X, local, out);
    case SupportKind::hull: return add_hull_face(*s.hull, *shape.prepared, X, local, hint, out);
    case SupportKind::cylinder:
      if (std::fabs(local.z) < side_sine) return add_side(s.size, X, local, out);
      if (local.x * local.x + local.y * local.y < 0.25) return add_end(s.size, X, local, out);
      break;
    case SupportKind::point:
    case SupportKind::ellipsoid:
    case SupportKind::half_space: break;
  }
  out.add(X * find_support(s, local, hint).p, 0);
}

}  // namespace ugoki::collision
