#include "ugoki/collision/hull.h"

#include "ugoki/collision/hull_walk.h"

namespace ugoki::collision {

std::int32_t find_extreme_vertex(const Hull& hull, const Vec3& d, std::int32_t start) {
  if (!hull.walk.nodes.empty()) return walk_to_extreme(hull, d, start);
  std::int32_t best = 0;
  double highest = -1e308;
  for (std::size_t v = 0; v < hull.vertices.size(); ++v) {
    const Vec3& p = hull.vertices[v];
    const double f = p.x * d.x + p.y * d.y + p.z * d.z;
    if (f > highest) highest = f, best = static_cast<std::int32_t>(v);
  }
  return best;
}

std::int32_t highest_of_overflow(const Hull& hull, const HullWalk::Node& node, const Vec3& d, double& highest, std::int32_t fallback) {
  const auto first = static_cast<std::size_t>(node.more), last = first + static_cast<std::size_t>(node.more_count);
  for (std::size_t i = first; i < last; ++i) {
    const std::int32_t v = hull.walk.overflow[i];
    const Vec3& p = hull.vertices[static_cast<std::size_t>(v)];
    const double f = p.x * d.x + p.y * d.y + p.z * d.z;
    if (f > highest) highest = f, fallback = v;
  }
  return fallback;
}

std::int32_t seed_vertex(const Hull& hull, const Vec3& d) {
  if (hull.walk.cells == 0) return 0;
  return hull.walk.seeds[static_cast<std::size_t>(direction_cell(d, hull.walk.cells))];
}

}  // namespace ugoki::collision
