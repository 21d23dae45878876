#include "terrain.h"

#include <cmath>
#include <cstdint>

#include "ugoki/spatial/elementary.h"

namespace ugoki::bench {

namespace {

/// Number between -1 and 1 that depends only on the tile (splitmix64, Steele et al. 2014).
double random_of(int i, int j) {
  std::uint64_t z =
      (static_cast<std::uint64_t>(static_cast<std::uint32_t>(i)) << 32 | static_cast<std::uint32_t>(j)) + 0x9e3779b97f4a7c15ull;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
  z ^= z >> 31;
  return 2 * static_cast<double>(z >> 11) / 9007199254740992.0 - 1;
}

}  // namespace

MechanismPtr make_terrain(const Terrain& terrain, const Vec3& start, const Vec3& direction, const Vec3& centre, double friction) {
  const Vec3 side = cross(Vec3{0, 0, 1}, direction);
  const Mat3 R = rotation_about({0, 0, 1}, ugoki::atan2(direction.y, direction.x));
  LinkSpec link;
  link.name = "terrain";
  link.joint.type = JointType::fixed;
  constexpr double depth = 1, first = 1;  // m: half thickness of the boxes; distance from the start to the first slope or step
  /// Adds a box with its top at height z. @param x, y m: centre of the top, along and across the walk @param a, b m: half lengths
  const auto add = [&](double x, double y, double z, double a, double b) {
    link.shapes.push_back(Shape::box({a, b, depth}, {R, start + direction * x + side * y + Vec3{0, 0, z - depth}}));
  };
  constexpr double width = 200;  // m: half width
  const double x = dot(centre - start, direction), y = dot(centre - start, side);
  const auto around = [](double p, double edge) { return static_cast<int>(std::floor(p / edge)); };
  if (terrain.slope != 0) {
    add(first - width, 0, 0, width, width);
    const double angle = terrain.slope * pi / 180;
    const Mat3 tilted = rotation_about(side, -angle) * R;
    const Vec3 top = start + direction * first + (tilted * Vec3{1, 0, 0}) * width;
    link.shapes.push_back(Shape::box({width, width, depth}, {tilted, top - (tilted * Vec3{0, 0, 1}) * depth}));
  } else if (terrain.steps != 0) {
    constexpr double platform = 1.5;  // m
    for (int i = around(x - terrain_radius - first, platform); i * platform < x + terrain_radius - first; ++i)
      add(first + (i + 0.5) * platform, 0, i >= 0 && i % 2 == 0 ? terrain.steps : 0, 0.5 * platform, width);
  } else {
    constexpr double edge = 0.5;  // m
    for (int i = around(x - terrain_radius, edge); i * edge < x + terrain_radius; ++i)
      for (int j = around(y - terrain_radius, edge); j * edge < y + terrain_radius; ++j) {
        const double u = (i + 0.5) * edge, v = (j + 0.5) * edge;
        add(u, v, std::hypot(u, v) < first ? 0 : terrain.tiles * random_of(i, j), 0.5 * edge, 0.5 * edge);
      }
  }
  for (Shape& shape : link.shapes) shape.friction = friction;
  MechanismSpec spec;
  spec.name = "terrain";
  spec.links.push_back(std::move(link));
  return Mechanism::make(std::move(spec)).value();
}

}  // namespace ugoki::bench
