// The map of the ground: rays downwards against closed forms and against a search without a tree.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "ugoki/control/ground_map.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::control {
namespace {

MechanismPtr fixed(std::vector<Shape> shapes) {
  LinkSpec link;
  link.name = "ground";
  link.joint.type = JointType::fixed;
  link.shapes = std::move(shapes);
  MechanismSpec spec;
  spec.name = "ground";
  spec.links.push_back(std::move(link));
  return Mechanism::make(std::move(spec)).value();
}

GroundMap map_of(std::vector<Shape> shapes, double floor = 0) {
  const std::vector<MechanismPtr> systems{fixed({}), fixed(std::move(shapes))};
  return {systems, 0, floor};
}

TEST(GroundMap, FindsTheHeightAndTheNormalOfASlope) {
  const double slope = 0.2;  // rad
  const Mat3 R = rotation_about({0, 1, 0}, -slope);
  const GroundMap map = map_of({Shape::box({5, 5, 1}, {R, R * Vec3{0, 0, -1}})});
  for (double x = -3; x <= 3; x += 0.37) {
    const GroundMap::Point p = map.below({x, 0.4 * x, 4});
    EXPECT_NEAR(p.height, std::max(0.0, x * std::tan(slope)), 1e-12);
    if (x > 0) EXPECT_LT(norm(p.normal - R * Vec3{0, 0, 1}), 1e-12);
  }
}

TEST(GroundMap, FindsTheHeightOfRoundShapes) {
  const GroundMap sphere = map_of({Shape::sphere(0.5, {Mat3::identity(), {1, 2, 0.3}})});
  const GroundMap cylinder = map_of({Shape::cylinder(0.5, 0.4, {Mat3::identity(), {1, 2, 0.3}})});
  for (double x = 0.01; x < 0.6; x += 0.05) {
    const Vec3 from{1 + 0.6 * x, 2 - 0.8 * x, 2};
    EXPECT_NEAR(sphere.below(from).height, x < 0.5 ? 0.3 + std::sqrt(0.25 - x * x) : 0, 2e-4);
    EXPECT_NEAR(cylinder.below(from).height, x < 0.5 ? 0.7 : 0, 2e-4);
  }
  EXPECT_EQ(sphere.below({1, 2, 0.4}).height, 0) << "a shape that contains the start of the ray is ignored";
}

/// Height fields, also turned about the vertical: against the intersection of the ray with each triangle.
TEST(GroundMap, FindsTheTriangleOfAHeightField) {
  HeightField field;
  field.columns = 7;
  field.rows = 5;
  field.half_x = 2;
  field.half_y = 1.2;
  field.base = 0.5;
  std::mt19937 random(3);
  for (int i = 0; i < 35; ++i) field.heights.push_back(0.6 * static_cast<double>(random()) / 4294967296.0);
  const HeightFieldPtr shared = make_height_field(field, "field").value();
  const Pose X{rotation_about({0, 0, 1}, 0.7), {0.3, -0.2, 0.1}};
  const GroundMap map = map_of({Shape::height_field(shared, X)}, 0.05);
  int hits = 0;
  for (int i = 0; i < 400; ++i) {
    const Vec3 from{5 * static_cast<double>(random()) / 4294967296.0 - 2.5, 4 * static_cast<double>(random()) / 4294967296.0 - 2, 1.5};
    double height = 0.05;
    Vec3 normal{0, 0, 1};
    for (int r = 0; r + 1 < field.rows; ++r)
      for (int c = 0; c + 1 < field.columns; ++c)
        for (const bool upper : {false, true}) {
          const Vec3 a = X * shared->point(c, r), b = X * (upper ? shared->point(c + 1, r + 1) : shared->point(c + 1, r)),
                     d = X * (upper ? shared->point(c, r + 1) : shared->point(c + 1, r + 1));
          const auto area = [&](const Vec3& p, const Vec3& q) { return (p.x - from.x) * (q.y - from.y) - (p.y - from.y) * (q.x - from.x); };
          const double u = area(b, d), v = area(d, a), w = area(a, b), all = u + v + w;
          if (!(u >= 0 && v >= 0 && w >= 0)) continue;
          height = std::max(height, (u * a.z + v * b.z + w * d.z) / all);
          normal = normalized(cross(b - a, d - a));
        }
    const GroundMap::Point found = map.below(from);
    EXPECT_NEAR(found.height, height, 1e-12);
    if (height > 0.05) EXPECT_NEAR(norm(found.normal - normal), 0, 1e-12);
    hits += height > 0.05;
  }
  EXPECT_GT(hits, 150);
  EXPECT_EQ(map.below({0.3, -0.2, 0.0}).height, 0.05) << "a shape that contains the start of the ray is ignored";
}

TEST(GroundMap, AgreesWithASearchWithoutATree) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-4, 4), size(0.1, 0.8), angle(-1, 1);
  std::vector<Shape> shapes;
  std::vector<GroundMap> single;
  for (int i = 0; i < 60; ++i) {
    const Mat3 R = rotation_about(normalized(Vec3{angle(random), angle(random), 1}), angle(random));
    const Pose X{R, {place(random), place(random), 0.3 * place(random)}};
    shapes.push_back(i % 3 ? Shape::box({size(random), size(random), size(random)}, X) : Shape::ellipsoid({size(random), 0.3, 0.4}, X));
    single.push_back(map_of({shapes.back()}, -2));
  }
  const GroundMap map = map_of(shapes, -2);
  for (int i = 0; i < 500; ++i) {
    const Vec3 from{place(random), place(random), 3};
    double height = -2;
    for (const GroundMap& m : single) height = std::max(height, m.below(from).height);
    EXPECT_EQ(map.below(from).height, height);
  }
}

TEST(GroundMap, LeavesOutTheCharacterAndShapesThatMove) {
  LinkSpec box;
  box.name = "box";
  box.joint.type = JointType::floating;
  box.inertia = solid_inertia(Shape::box({1, 1, 1}), 100);
  box.shapes.push_back(Shape::box({1, 1, 1}));
  MechanismSpec spec;
  spec.name = "box";
  spec.links.push_back(box);
  const std::vector<MechanismPtr> systems{fixed({Shape::box({1, 1, 2})}), Mechanism::make(std::move(spec)).value(),
                                          fixed({Shape::box({1, 1, 0.5})})};
  const GroundMap map(systems, 0, -1);
  EXPECT_EQ(map.below({0, 0, 5}).height, 0.5);
  EXPECT_EQ(map.below({3, 0, 5}).height, -1);
  EXPECT_TRUE(map.contains(-1, -1) && map.contains(2, 0));
  EXPECT_FALSE(map.contains(0, 0) || map.contains(1, 0));
}

}  // namespace
}  // namespace ugoki::control
