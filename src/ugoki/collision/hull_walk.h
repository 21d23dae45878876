#pragma once
// Hill climbing to a hull's extreme vertex, inline for the inner loops of Gilbert's method.

#include "ugoki/collision/hull.h"
#include "ugoki/collision/lanes_of_four.h"

namespace ugoki::collision {

/// Index of the cell of the cube map of directions (HullWalk::seeds) that contains the direction d; 0 for d = 0.
static inline std::int32_t direction_cell(const Vec3& d, std::int32_t cells) {
  const double x = d.x < 0 ? -d.x : d.x, y = d.y < 0 ? -d.y : d.y, z = d.z < 0 ? -d.z : d.z;
  double u, v, m;
  std::int32_t side;
  if (x >= y && x >= z) {
    m = x, u = d.y, v = d.z, side = d.x < 0 ? 1 : 0;
  } else if (y >= z) {
    m = y, u = d.z, v = d.x, side = d.y < 0 ? 3 : 2;
  } else {
    m = z, u = d.x, v = d.y, side = d.z < 0 ? 5 : 4;
  }
  if (!(m > 0)) return 0;
  const double scale = 0.5 * cells / m;
  std::int32_t i = static_cast<std::int32_t>((u + m) * scale), j = static_cast<std::int32_t>((v + m) * scale);
  i = i < cells ? i : cells - 1;
  j = j < cells ? j : cells - 1;
  return (side * cells + i) * cells + j;
}

/// Index of the neighbour in `node` with the maximum d . x, if that exceeds `highest`; otherwise `fallback`.
/// @param highest [in, out] the value to exceed; set to d . x of the returned neighbour
static inline std::int32_t highest_of(const HullWalk::Node& node, const Vec3& d, double& highest, std::int32_t fallback) {
  Four x, y, z, x2, y2, z2;
  __builtin_memcpy(&x, node.x, sizeof x);
  __builtin_memcpy(&y, node.y, sizeof y);
  __builtin_memcpy(&z, node.z, sizeof z);
  __builtin_memcpy(&x2, node.x + 4, sizeof x2);
  __builtin_memcpy(&y2, node.y + 4, sizeof y2);
  __builtin_memcpy(&z2, node.z + 4, sizeof z2);
  const Four low = x * d.x + y * d.y + z * d.z, high = x2 * d.x + y2 * d.y + z2 * d.z;
  const Four best = high > low ? high : low;
  FourInts lane = high > low ? FourInts{4, 5, 6, 7} : FourInts{0, 1, 2, 3};
  const double f01 = best[1] > best[0] ? best[1] : best[0], f23 = best[3] > best[2] ? best[3] : best[2];
  const std::int64_t l01 = best[1] > best[0] ? lane[1] : lane[0], l23 = best[3] > best[2] ? lane[3] : lane[2];
  const double f = f23 > f01 ? f23 : f01;
  const std::int32_t vertex = node.vertex[f23 > f01 ? l23 : l01];
  fallback = f > highest ? vertex : fallback;
  highest = f > highest ? f : highest;
  return fallback;
}

/// Same as highest_of(), for the neighbours of the node's vertex after the eighth (HullWalk::overflow).
std::int32_t highest_of_overflow(const Hull& hull, const HullWalk::Node& node, const Vec3& d, double& highest, std::int32_t fallback);

/// Inline find_extreme_vertex() (hull.h) for a hull with `walk`; v: start vertex. The loop ends, because each step increases the computed
/// value d . x.
static inline std::int32_t walk_to_extreme(const Hull& hull, const Vec3& d, std::int32_t v) {
  const HullWalk::Node* nodes = hull.walk.nodes.data();
  if (!hull.walk.scan.empty()) {
    double f = -1e308;
    std::int32_t best = 0;
    for (const HullWalk::Node& node : hull.walk.scan) best = highest_of(node, d, f, best);
    return best;
  }
  double f = nodes[v].own[0] * d.x + nodes[v].own[1] * d.y + nodes[v].own[2] * d.z;
  for (;;) {
    const HullWalk::Node& node = nodes[v];
    std::int32_t next = highest_of(node, d, f, v);
    if (node.more_count > 0) [[unlikely]]
      next = highest_of_overflow(hull, node, d, f, next);
    if (next == v) return v;
    v = next;
  }
}

}  // namespace ugoki::collision
