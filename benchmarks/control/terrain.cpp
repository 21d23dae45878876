#include "terrain.h"

#include <cmath>
#include <cstdint>

#include "ugoki/spatial/elementary.h"

namespace ugoki::bench {

MechanismPtr make_terrain(const Terrain& terrain, const Vec3& start, const Vec3& direction, double length, double friction) {
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
  constexpr double width = 8;  // m: half width
  if (terrain.slope != 0) {
    add(first - 10, 0, 0, 10, width);
    const double angle = terrain.slope * pi / 180, half = 0.5 * length;
    const Mat3 tilted = rotation_about(side, -angle) * R;
    const Vec3 top = start + direction * first + (tilted * Vec3{1, 0, 0}) * half;
    link.shapes.push_back(Shape::box({half, width, depth}, {tilted, top - (tilted * Vec3{0, 0, 1}) * depth}));
  } else if (terrain.steps != 0) {
    constexpr double platform = 1.5;  // m
    add(first - 10, 0, 0, 10, width);
    for (int i = 0; i * platform < length; ++i) add(first + (i + 0.5) * platform, 0, i % 2 == 0 ? terrain.steps : 0, 0.5 * platform, width);
  } else {
    constexpr double edge = 0.5;  // m
    std::uint64_t random = 88172645463325252ull;
    for (int i = -4; i * edge < length; ++i)
      for (int j = -6; j <= 6; ++j) {
        random ^= random << 13, random ^= random >> 7, random ^= random << 17;  // xorshift (Marsaglia 2003)
        const double height = terrain.tiles * (2 * static_cast<double>(random >> 11) / 9007199254740992.0 - 1);
        add((i + 0.5) * edge, j * edge, (i + 0.5) * edge < first ? 0 : height, 0.5 * edge, 0.5 * edge);
      }
  }
  for (Shape& shape : link.shapes) shape.friction = friction;
  MechanismSpec spec;
  spec.name = "terrain";
  spec.links.push_back(std::move(link));
  return Mechanism::make(std::move(spec)).value();
}

}  // namespace ugoki::bench
