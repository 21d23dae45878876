#include "ugoki/collision/manifold.h"

#include <gtest/gtest.h>

#include <set>

#include "random_shapes.h"
#include "ugoki/collision/distance.h"

namespace ugoki::collision {
namespace {

using test::Random;

Pose at(double x, double y, double z) { return {Mat3::identity(), {x, y, z}}; }
Pose turned(const Vec3& axis, double angle, const Vec3& p) { return {rotation_about(normalized(axis), angle), p}; }

Manifold manifold(const Shape& a, const Pose& A, const Shape& b, const Pose& B, double margin) {
  Manifold out;
  find_manifold(a, A * a.X_BS, b, B * b.X_BS, margin, out);
  return out;
}
std::vector<ManifoldPoint> points(const Manifold& m) { return {m.points.begin(), m.points.begin() + m.count}; }
double minimum(const Manifold& m) {
  double d = 1e300;
  for (const ManifoldPoint& p : points(m)) d = std::min(d, p.distance);
  return d;
}

TEST(Manifold, MinimumDistanceEqualsTrueDistance) {
  Random random(23);
  int found = 0;
  for (int i = 0; i < 30000 && !testing::Test::HasFailure(); ++i) {
    const Shape a = random.shape(), b = random.shape();
    const Pose A = random.pose(0.6), B = random.pose(0.6);
    const double margin = random.in(0, 0.3);
    const double d = distance(a, A, b, B);
    const Manifold m = manifold(a, A, b, B, margin);
    SCOPED_TRACE(testing::Message() << "case " << i << ", types " << int(a.type) << " " << int(b.type) << ", distance " << d);
    const bool boxes = a.type == ShapeType::box && b.type == ShapeType::box;
    const double smallest =
        std::min({a.half_extents.x, a.half_extents.y, a.half_extents.z, b.half_extents.x, b.half_extents.y, b.half_extents.z});
    const double tolerance = boxes ? 1e-4 * smallest : 1e-9;
    if (d < margin - tolerance) {
      ASSERT_GT(m.count, 0);
      EXPECT_NEAR(minimum(m), d, tolerance + 1e-6 * 0.3);
      ++found;
    } else if (d > margin) {
      EXPECT_EQ(m.count, 0);
    }
    std::set<std::uint32_t> features;
    for (const ManifoldPoint& p : points(m)) {
      EXPECT_NEAR(norm(p.n), 1, 1e-12);
      EXPECT_LT(p.distance, margin);
      EXPECT_TRUE(features.insert(p.feature).second);
      EXPECT_LT(p.feature, 1U << 24);
      // The contact point p.p is half way between the surfaces; pa and pb are the points on the surfaces.
      const Vec3 pa = p.p + p.n * (0.5 * p.distance), pb = p.p - p.n * (0.5 * p.distance);
      EXPECT_LT(norm(test::project(a, A, pa) - pa), boxes ? 1e-6 : 1e-9);
      EXPECT_LT(norm(test::project(b, B, pb) - pb), boxes ? 1e-6 : 1e-9);
    }
  }
  EXPECT_GT(found, 10000);
}

TEST(Manifold, ExchangedShapesHaveMirroredPoints) {
  Random random(29);
  for (int i = 0; i < 5000 && !testing::Test::HasFailure(); ++i) {
    const Shape a = random.shape(), b = random.shape();
    const Pose A = random.pose(0.5), B = random.pose(0.5);
    const Manifold m = manifold(a, A, b, B, 0.05), t = manifold(b, B, a, A, 0.05);
    const bool boxes = a.type == ShapeType::box && b.type == ShapeType::box;
    ASSERT_EQ(m.count > 0, t.count > 0);
    if (m.count == 0) continue;
    EXPECT_NEAR(minimum(m), minimum(t), boxes ? 1e-4 * 0.5 : 1e-12);
    if (!boxes) {
      EXPECT_EQ(m.count, t.count) << "case " << i;
    }
  }
}

TEST(Manifold, ParallelCapsulesTouchAtTwoPoints) {
  const Shape long_one = Shape::capsule(0.1, {-1, 0, 0}, {1, 0, 0}), short_one = Shape::capsule(0.1, {-0.3, 0, 0}, {0.3, 0, 0});
  for (const double tilt : {0.0, 1e-9, 1e-4, -1e-4, 0.01}) {
    const Manifold m = manifold(short_one, turned({0, 1, 0}, tilt, {0.1, 0, 0.19}), long_one, {}, 0.05);
    ASSERT_EQ(m.count, 2) << tilt;
    EXPECT_NEAR(std::fabs(m.points[0].p.x - m.points[1].p.x), 0.6, 1e-3);
    EXPECT_NEAR(m.points[0].distance + m.points[1].distance, -0.02, 1e-4);
    EXPECT_LT(norm(m.points[0].n - Vec3{0, 0, 1}), 0.02);
  }
  // The capsules cross near one end: contacts are at the crossing and at the farther end.
  const Manifold crossed = manifold(short_one, turned({0, 0, 1}, 0.1, {0.1, 0.02, 0.19}), long_one, {}, 0.05);
  ASSERT_EQ(crossed.count, 2);
  EXPECT_NEAR(crossed.points[0].distance, -0.01, 1e-12);
  EXPECT_NEAR(crossed.points[0].p.x, 0.1 - 0.02 / std::tan(0.1), 1e-9);
  EXPECT_NEAR(crossed.points[1].p.x, 0.1 + 0.3 * std::cos(0.1), 0.01);
  EXPECT_EQ(manifold(short_one, turned({0, 0, 1}, 1, {0.1, 0, 0.19}), long_one, {}, 0.05).count, 1);
  EXPECT_EQ(manifold(short_one, at(1.49, 0, 0), long_one, {}, 0.05).count, 1);  // capsules in line touch with their caps
}

TEST(Manifold, CapsuleOnBoxHasTwoPoints) {
  const Shape box = Shape::box({1, 1, 0.5}), capsule = Shape::capsule(0.1, {-0.5, 0, 0}, {0.5, 0, 0});
  const auto expect_two = [&](const Pose& X, double x0, double x1, double d) {
    const Manifold m = manifold(capsule, X, box, {}, 0.05);
    ASSERT_EQ(m.count, 2);
    EXPECT_NEAR(std::min(m.points[0].p.x, m.points[1].p.x), x0, 1e-9);
    EXPECT_NEAR(std::max(m.points[0].p.x, m.points[1].p.x), x1, 1e-9);
    for (const ManifoldPoint& p : points(m)) {
      EXPECT_NEAR(p.distance, d, 1e-9);
      EXPECT_NEAR(p.p.z, 0.5 + 0.5 * d, 1e-9);
      EXPECT_LT(norm(p.n - Vec3{0, 0, 1}), 1e-9);
    }
  };
  expect_two(at(0, 0, 0.62), -0.5, 0.5, 0.02);                                             // above the box
  expect_two(at(0, 0, 0.58), -0.5, 0.5, -0.02);                                            // pressed into the box
  expect_two(at(0, 0, 0.45), -0.5, 0.5, -0.15);                                            // the capsule's axis is inside the box
  expect_two(at(0.8, 0, 0.58), 0.3, 1.0, -0.02);                                           // overhanging the box
  EXPECT_EQ(manifold(capsule, turned({0, 1, 0}, 1, {0, 0, 0.9}), box, {}, 0.2).count, 1);  // only one end is near
  // The capsule is parallel to an edge of the box and overlaps the edge diagonally.
  EXPECT_EQ(manifold(capsule, at(0, 1.05, 0.55), box, {}, 0.05).count, 2);
  // Exchanged shapes: the normal is reversed.
  const Manifold mirrored = manifold(box, {}, capsule, at(0, 0, 0.58), 0.05);
  ASSERT_EQ(mirrored.count, 2);
  EXPECT_LT(norm(mirrored.points[0].n + Vec3{0, 0, 1}), 1e-12);
}

TEST(Manifold, BoxOnBoxHasFourCorners) {
  const Shape small = Shape::box({0.2, 0.3, 0.1}), large = Shape::box({1, 1, 0.5});
  for (const double angle : {0.0, 1e-12, 0.3, pi / 4}) {
    for (const double gap : {0.01, 0.0, -0.01}) {
      const Pose A = turned({0, 0, 1}, angle, {0.1, 0.2, 0.6 + gap});
      const Manifold m = manifold(small, A, large, {}, 0.05);
      ASSERT_EQ(m.count, 4) << angle << " " << gap;
      Vec3 middle;
      for (const ManifoldPoint& p : points(m)) {
        EXPECT_NEAR(p.distance, gap, 1e-12);
        EXPECT_LT(norm(p.n - Vec3{0, 0, 1}), 1e-12);
        EXPECT_NEAR(norm(p.p - Vec3{0.1, 0.2, 0.5 + gap / 2}), std::sqrt(0.13), 1e-12);
        middle += p.p * 0.25;
      }
      EXPECT_LT(norm(middle - Vec3{0.1, 0.2, 0.5 + gap / 2}), 1e-12);
    }
  }
  // If the upper box is tilted by at most 1e-5 rad, the face contact remains, although an edge separates the boxes slightly better.
  for (const double angle : {0.0, 0.2, 0.6}) {
    for (const double tilt : {1e-9, 1e-7, 1e-5}) {
      Pose A = turned({0, 0, 1}, angle, {0.85, 0.9, 0.595});  // overhangs a corner
      A.R = rotation_about(normalized(Vec3{1, 0.4, 0}), tilt) * A.R;
      EXPECT_EQ(manifold(small, A, large, {}, 0.05).count, 4) << angle << " " << tilt;
    }
  }
  // Boxes of the same size, turned so that the common face is an octagon: four of its corners become contact points.
  const Shape cube = Shape::box({0.5, 0.5, 0.5});
  const Manifold octagon = manifold(cube, turned({0, 0, 1}, pi / 4, {0, 0, 0.99}), cube, {}, 0.05);
  EXPECT_EQ(octagon.count, 4);
  EXPECT_EQ(manifold(cube, at(0, 0, 0.99), cube, {}, 0.05).count, 4);
}

/// The common face of the boxes is an octagon. Rounding tilts a resting box by about 1e-7 rad in every step.
TEST(Manifold, RestingBoxKeepsItsPoints) {
  const Shape box = Shape::box({0.1, 0.1, 0.1});
  Random random(7);
  for (const double angle : {0.1, 0.3, 0.7}) {
    std::set<std::uint32_t> kept;
    for (int k = 0; k < 200; ++k) {
      Pose A = turned({0, 0, 1}, angle, {0, 0, 0.2});
      A.R = rotation_about(random.unit(), random.in(0, 1e-6)) * A.R;
      std::set<std::uint32_t> features;
      for (const ManifoldPoint& p : points(manifold(box, A, box, {}, 0.02))) features.insert(p.feature);
      if (k == 0) kept = features;
      EXPECT_EQ(features.size(), 4U);
      EXPECT_EQ(features, kept) << angle << ", pose " << k;
    }
  }
}

TEST(Manifold, EdgeOnEdgeHasOnePoint) {
  const Shape cube = Shape::box({1, 1, 1});
  const Manifold m = manifold(cube, turned({0, 1, 0}, pi / 4, {0, 0, 2.8}), cube, turned({1, 0, 0}, pi / 4, {}), 0.05);
  ASSERT_EQ(m.count, 1);
  EXPECT_NEAR(m.points[0].distance, 2.8 - 2 * std::sqrt(2.0), 1e-12);
  EXPECT_LT(norm(m.points[0].p - Vec3{0, 0, 1.4}), 1e-12);
  EXPECT_LT(norm(m.points[0].n - Vec3{0, 0, 1}), 1e-12);
}

TEST(Manifold, GroundContactPoints) {
  Manifold m;
  find_ground_manifold(Shape::sphere(0.1), at(1, 2, 0.15), 0, 0.1, m);
  ASSERT_EQ(m.count, 1);
  EXPECT_LT(norm(m.points[0].p - Vec3{1, 2, 0.025}), 1e-15);
  EXPECT_NEAR(m.points[0].distance, 0.05, 1e-15);
  EXPECT_EQ(m.points[0].n, (Vec3{0, 0, 1}));

  const Shape capsule = Shape::capsule(0.1, {-1, 0, 0}, {1, 0, 0});
  find_ground_manifold(capsule, at(0, 0, 0.08) * capsule.X_BS, 0, 0.01, m);
  ASSERT_EQ(m.count, 2);
  EXPECT_NEAR(m.points[0].distance, -0.02, 1e-15);
  find_ground_manifold(capsule, turned({0, 1, 0}, 0.3, {0, 0, 0.3}) * capsule.X_BS, 0, 0.01, m);
  ASSERT_EQ(m.count, 1);

  const Shape box = Shape::box({0.3, 0.2, 0.1});
  find_ground_manifold(box, at(0, 0, 0.6), 0.5, 0.01, m);
  ASSERT_EQ(m.count, 4);
  for (const ManifoldPoint& p : points(m)) EXPECT_NEAR(p.distance, 0, 1e-15);
  find_ground_manifold(box, at(0, 0, 0.5), 0.5, 0.11, m);
  EXPECT_EQ(m.count, 8);  // every corner is within the margin
}

TEST(Manifold, GroundMinimumDistanceEqualsTrueDistance) {
  Random random(31);
  for (int i = 0; i < 3000; ++i) {
    const Shape s = random.shape();
    const Pose X = random.pose(0.5);
    const double d = distance_to_ground(s, X, -0.1);
    Manifold m;
    find_ground_manifold(s, X * s.X_BS, -0.1, 0.2, m);
    EXPECT_EQ(m.count > 0, d < 0.2);
    if (m.count > 0) {
      EXPECT_NEAR(minimum(m), d, 1e-13);
    }
  }
}

// A box slides across another box and over its rim, turning slowly. A contact point whose feature persists moves at most 20 times as far
// as the box in each step. The depth is continuous even where features change.
TEST(Manifold, SlidingBoxMovesItsPointsContinuously) {
  const Shape box = Shape::box({0.2, 0.15, 0.1}), table = Shape::box({0.5, 0.5, 0.5});
  const double step = 1e-4;
  Manifold before;
  int changes = 0, steps = 0;
  for (double x = 0; x < 0.6; x += step, ++steps) {
    const Pose A = turned({0.1, 0.05, 1}, 0.5 * x, {x, 0.1, 0.597});
    const Manifold now = manifold(box, A, table, {}, 0.02);
    if (steps > 0) {
      ASSERT_NEAR(minimum(now), minimum(before), 5 * step) << x;
      std::set<std::uint32_t> old_features, new_features;
      for (const ManifoldPoint& p : points(now)) {
        new_features.insert(p.feature);
        for (const ManifoldPoint& q : points(before))
          if (p.feature == q.feature) {
            ASSERT_LT(norm(p.p - q.p), 20 * step) << x;
          }
      }
      for (const ManifoldPoint& q : points(before)) old_features.insert(q.feature);
      changes += old_features != new_features ? 1 : 0;
    }
    before = now;
  }
  EXPECT_LT(changes, 25) << "features alternate from step to step";
}

TEST(Manifold, DegeneratePosesGiveFinitePoints) {
  const Shape shapes[] = {Shape::sphere(0.2), Shape::capsule(0.1, {0, 0, -0.4}, {0, 0, 0.4}), Shape::capsule(0.1, {0.2, 0, 0}, {0.2, 0, 0}),
                          Shape::box({0.3, 0.2, 0.1})};
  const Pose poses[] = {
      {}, at(0, 0, 0.4), at(0.3, 0.2, 0.1), at(0.6, 0, 0), at(0.6, 0.4, 0.2), turned({1, 0, 0}, pi / 2, {}), turned({1, 1, 1}, 1e-8, {})};
  for (const Shape& a : shapes)
    for (const Shape& b : shapes)
      for (const Pose& X : poses) {
        const Manifold m = manifold(a, X, b, {}, 1);
        EXPECT_GT(m.count, 0);
        for (const ManifoldPoint& p : points(m)) {
          EXPECT_TRUE(is_finite(p.p) && std::isfinite(p.distance));
          EXPECT_NEAR(norm(p.n), 1, 1e-12);
        }
      }
}

}  // namespace
}  // namespace ugoki::collision
