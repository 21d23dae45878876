#include "ugoki/geometry/planar_hull.h"

#include <algorithm>

namespace ugoki::geometry {
namespace {

/// True if b is left of the directed line from a to c, or on this line, so that b is not a corner of the hull.
bool superfluous(const PlanarPoint& a, const PlanarPoint& b, const PlanarPoint& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x) <= 1e-14;
}

}  // namespace

std::vector<std::int32_t> planar_hull(std::vector<PlanarPoint> points) {
  std::sort(points.begin(), points.end(), [](const PlanarPoint& a, const PlanarPoint& b) {
    return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.index < b.index;
  });
  std::vector<PlanarPoint> chain;
  const auto add = [&](const PlanarPoint& p, std::size_t start) {
    while (chain.size() >= start + 2 && superfluous(chain[chain.size() - 2], chain.back(), p)) chain.pop_back();
    chain.push_back(p);
  };
  for (const PlanarPoint& p : points) add(p, 0);
  const std::size_t lower = chain.size() - 1;
  for (auto p = points.rbegin() + 1; p != points.rend(); ++p) add(*p, lower);
  chain.pop_back();
  std::vector<std::int32_t> out;
  out.reserve(chain.size());
  for (const PlanarPoint& p : chain) out.push_back(p.index);
  return out;
}

}  // namespace ugoki::geometry
