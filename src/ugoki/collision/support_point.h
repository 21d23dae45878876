#pragma once
// Inline version of find_support() for the inner loops of Gilbert's method.

#include <cmath>

#include "ugoki/collision/hull_walk.h"
#include "ugoki/collision/support.h"

namespace ugoki::collision {

/// Point (px, py) of a disc of radius r that is farthest along (x, y).
static inline void support_of_disc(double r, double x, double y, double& px, double& py) {
  const double big = std::fmax(std::fabs(x), std::fabs(y));
  if (!(big > 1e-300)) {
    px = r, py = 0;
    return;
  }
  const double u = x / big, v = y / big, s = r / std::sqrt(u * u + v * v);
  px = u * s, py = v * s;
}

/// Same result as find_support() (support.h).
static inline SupportPoint support_point(const Support& s, const Vec3& d, std::int32_t hint) {
  const Vec3& h = s.size;
  switch (s.kind) {
    case SupportKind::segment: return {{0, 0, d.z >= 0 ? h.z : -h.z}, d.z >= 0 ? 1 : 0};
    case SupportKind::box: {
      const bool x = d.x >= 0, y = d.y >= 0, z = d.z >= 0;
      return {{x ? h.x : -h.x, y ? h.y : -h.y, z ? h.z : -h.z}, (x ? 1 : 0) + (y ? 2 : 0) + (z ? 4 : 0)};
    }
    case SupportKind::cylinder: {
      SupportPoint out{{0, 0, d.z >= 0 ? h.z : -h.z}, 0};
      support_of_disc(h.x, d.x, d.y, out.p.x, out.p.y);
      return out;
    }
    case SupportKind::ellipsoid: {
      const double big = std::fmax(std::fabs(d.x), std::fmax(std::fabs(d.y), std::fabs(d.z)));
      const Vec3 u{h.x * (d.x / big), h.y * (d.y / big), h.z * (d.z / big)};
      const double length = norm(u);
      if (!(length > 0)) return {{h.x, 0, 0}, 0};
      return {{h.x * (u.x / length), h.y * (u.y / length), h.z * (u.z / length)}, 0};
    }
    case SupportKind::hull: {
      const std::int32_t v = s.hull->walk.nodes.empty() ? find_extreme_vertex(*s.hull, d, 0) : walk_to_extreme(*s.hull, d, hint);
      return {s.hull->vertices[static_cast<std::size_t>(v)], v};
    }
    case SupportKind::point:
    case SupportKind::half_space: break;
  }
  return {};
}

/// Sets p [m, shape's frame] to the corner of a polytope with the index `vertex` (SupportPoint::vertex). Returns false for curved shapes
/// and for invalid indices.
static inline bool corner_of(const Support& s, std::int32_t vertex, Vec3& p) {
  const Vec3& h = s.size;
  switch (s.kind) {
    case SupportKind::point: p = {}; return vertex == 0;
    case SupportKind::segment: p = {0, 0, vertex == 1 ? h.z : -h.z}; return vertex == 0 || vertex == 1;
    case SupportKind::box:
      p = {(vertex & 1) != 0 ? h.x : -h.x, (vertex & 2) != 0 ? h.y : -h.y, (vertex & 4) != 0 ? h.z : -h.z};
      return vertex >= 0 && vertex < 8;
    case SupportKind::hull:
      if (vertex < 0 || static_cast<std::size_t>(vertex) >= s.hull->vertices.size()) return false;
      p = s.hull->vertices[static_cast<std::size_t>(vertex)];
      return true;
    default: return false;
  }
}

}  // namespace ugoki::collision
