#include "ugoki/collision/distance.h"

#include <gtest/gtest.h>

#include "random_shapes.h"

namespace ugoki::collision {
namespace {

using test::Random;

Pose at(double x, double y, double z) { return {Mat3::identity(), {x, y, z}}; }
Pose turned(const Vec3& axis, double angle, const Vec3& p) { return {rotation_about(axis, angle), p}; }

struct Nearest {
  Vec3 pa, pb, n;
  double d;
};
Nearest nearest(const Shape& a, const Pose& A, const Shape& b, const Pose& B) {
  Nearest out{};
  out.d = distance(a, A, b, B, &out.pa, &out.pb, &out.n);
  return out;
}

/// Checks that (d, n, pa, pb) is the signed distance, however it was computed: the points are in the shapes and differ by n d, and the slab
/// with normal n between the shapes has the thickness d. For shapes that are apart this proves that d is the minimum.
void expect_certified(const Shape& a, const Pose& A, const Shape& b, const Pose& B, const Nearest& r, double tolerance = 1e-11) {
  EXPECT_TRUE(std::isfinite(r.d));
  EXPECT_NEAR(norm(r.n), 1, 1e-12);
  EXPECT_LT(norm(r.pa - r.pb - r.n * r.d), tolerance);
  EXPECT_NEAR(test::separation(a, A, b, B, r.n), r.d, tolerance);
  EXPECT_LT(norm(test::project(a, A, r.pa) - r.pa), tolerance);
  EXPECT_LT(norm(test::project(b, B, r.pb) - r.pb), tolerance);
}

TEST(Distance, SphereSphere) {
  const Nearest r = nearest(Shape::sphere(0.5), at(0, 0, 3), Shape::sphere(0.25), at(0, 0, 1));
  EXPECT_DOUBLE_EQ(r.d, 1.25);
  EXPECT_EQ(r.n, (Vec3{0, 0, 1}));
  EXPECT_EQ(r.pa, (Vec3{0, 0, 2.5}));
  EXPECT_EQ(r.pb, (Vec3{0, 0, 1.25}));
  EXPECT_DOUBLE_EQ(nearest(Shape::sphere(1), at(0, 0, 0), Shape::sphere(1), at(1.5, 0, 0)).d, -0.5);
}

TEST(Distance, CapsuleCapsule) {
  const Shape capsule = Shape::capsule(0.1, {-1, 0, 0}, {1, 0, 0});
  EXPECT_NEAR(nearest(capsule, at(0, 0, 0), capsule, at(0, 0, 1)).d, 0.8, 1e-15);                                 // parallel
  EXPECT_NEAR(nearest(capsule, at(0, 0, 0), capsule, at(3, 0, 0)).d, 0.8, 1e-15);                                 // in line
  EXPECT_NEAR(nearest(capsule, at(0, 0, 0), capsule, turned({0, 0, 1}, pi / 2, {0.3, 0.2, 0.5})).d, 0.3, 1e-15);  // crossing
  EXPECT_NEAR(nearest(capsule, at(0, 0, 0), capsule, turned({0, 0, 1}, pi / 2, {0, 0, 0.05})).d, -0.15, 1e-15);
  EXPECT_NEAR(nearest(capsule, at(0, 0, 0), capsule, at(3, 3, 4)).d, std::sqrt(26.0) - 0.2, 1e-14);  // closest points at the ends
}

TEST(Distance, SphereBox) {
  const Shape box = Shape::box({1, 2, 3}), ball = Shape::sphere(0.5);
  EXPECT_DOUBLE_EQ(nearest(ball, at(2, 0, 0), box, {}).d, 0.5);
  EXPECT_DOUBLE_EQ(nearest(ball, at(2, 3, 0), box, {}).d, std::sqrt(2.0) - 0.5);
  EXPECT_DOUBLE_EQ(nearest(ball, at(2, 3, 4), box, {}).d, std::sqrt(3.0) - 0.5);
  const Nearest inside = nearest(ball, at(0.8, 0.1, -0.2), box, {});
  EXPECT_DOUBLE_EQ(inside.d, -0.7);
  EXPECT_EQ(inside.n, (Vec3{1, 0, 0}));
}

TEST(Distance, CapsuleBox) {
  const Shape box = Shape::box({1, 1, 1}), capsule = Shape::capsule(0.1, {-0.5, 0, 0}, {0.5, 0, 0});
  EXPECT_NEAR(nearest(capsule, at(0, 0, 2), box, {}).d, 0.9, 1e-15);
  EXPECT_NEAR(nearest(capsule, at(1.8, 0, 0), box, {}).d, 0.2, 1e-15);
  // Over the edge x = z = 1, at 45 degrees: the middle of the segment is at the distance (1.5 - 1) sqrt 2 from the edge.
  const Nearest edge = nearest(capsule, turned({0, 1, 0}, pi / 4, {1.5, 0, 1.5}), box, {});
  EXPECT_NEAR(edge.d, 0.5 * std::sqrt(2.0) - 0.1, 1e-14);
  EXPECT_LT(norm(edge.n - Vec3{std::sqrt(0.5), 0, std::sqrt(0.5)}), 1e-14);
  // The same segment inside the box: the shortest way out is across the edge.
  const Nearest sunk = nearest(capsule, turned({0, 1, 0}, pi / 4, {0.9, 0, 0.9}), box, {});
  EXPECT_NEAR(sunk.d, -0.1 * std::sqrt(2.0) - 0.1, 1e-14);
  EXPECT_LT(norm(sunk.n - Vec3{std::sqrt(0.5), 0, std::sqrt(0.5)}), 1e-14);
}

TEST(Distance, BoxBox) {
  const Shape box = Shape::box({1, 1, 1});
  EXPECT_NEAR(nearest(box, at(3, 0, 0), box, {}).d, 1, 1e-15);
  EXPECT_NEAR(nearest(box, at(3, 3, 0), box, {}).d, std::sqrt(2.0), 1e-15);
  EXPECT_NEAR(nearest(box, at(3, 3, 3), box, {}).d, std::sqrt(3.0), 1e-15);
  EXPECT_NEAR(nearest(box, at(1.5, 0.2, 0), box, {}).d, -0.5, 1e-15);
  // Edge against edge: both boxes are turned by 45 degrees, about perpendicular axes.
  const Pose lower = turned({1, 0, 0}, pi / 4, {0, 0, 0});
  EXPECT_NEAR(nearest(box, turned({0, 1, 0}, pi / 4, {0, 0, 3}), box, lower).d, 3 - 2 * std::sqrt(2.0), 1e-14);
  EXPECT_NEAR(nearest(box, turned({0, 1, 0}, pi / 4, {0, 0, 2.7}), box, lower).d, 2.7 - 2 * std::sqrt(2.0), 1e-14);
}

TEST(Distance, GroundDistanceMatchesSupport) {
  Random random;
  for (int i = 0; i < 3000; ++i) {
    const Shape s = random.shape();
    const Pose X = random.pose(1);
    Vec3 p;
    const double d = distance_to_ground(s, X, 0.3, &p);
    EXPECT_NEAR(d, -test::support(s, X, {0, 0, -1}) - 0.3, 1e-13);
    EXPECT_NEAR(p.z - 0.3, d, 1e-13);
    EXPECT_LT(norm(test::project(s, X, p) - p), 1e-12);
  }
}

TEST(Distance, CertifiedAtRandomPoses) {
  Random random;
  int apart = 0, together = 0;
  for (int i = 0; i < 30000 && !testing::Test::HasFailure(); ++i) {
    const Shape a = random.shape(), b = random.shape();
    const Pose A = random.pose(0.6), B = random.pose(0.6);
    const Nearest r = nearest(a, A, b, B);
    SCOPED_TRACE(testing::Message() << "seed " << test::seed << ", case " << i << ", types " << int(a.type) << " " << int(b.type) << " d "
                                    << r.d);
    expect_certified(a, A, b, B, r);
    (r.d > 0 ? apart : together)++;
  }
  EXPECT_GT(apart, 3000);
  EXPECT_GT(together, 3000);
}

// Separate shapes: alternating projections onto the two shapes converge to the closest points. Overlapping shapes: none of many random
// directions, and none near n, separates the shapes more than n.
TEST(Distance, MatchesBruteForce) {
  Random random(7);
  for (int i = 0; i < 1500 && !testing::Test::HasFailure(); ++i) {
    const Shape a = random.shape(), b = random.shape();
    const Pose A = random.pose(0.5), B = random.pose(0.5);
    const Nearest r = nearest(a, A, b, B);
    SCOPED_TRACE(testing::Message() << "case " << i << ", types " << int(a.type) << " " << int(b.type));
    if (r.d > 0.02) {
      Vec3 x = A.p, y;
      for (int k = 0; k < 4000; ++k) {
        y = test::project(b, B, x);
        x = test::project(a, A, y);
      }
      EXPECT_NEAR(norm(x - y), r.d, 2e-4);
      EXPECT_GE(norm(x - y), r.d - 1e-12);
      continue;
    }
    double best = -1e300;
    for (int k = 0; k < 1500; ++k) best = std::max(best, test::separation(a, A, b, B, random.unit()));
    for (int k = 0; k < 300; ++k) best = std::max(best, test::separation(a, A, b, B, normalized(r.n + random.vec(k < 150 ? 0.03 : 0.001))));
    EXPECT_LE(best, r.d + 1e-12);
  }
}

TEST(Distance, ExchangedShapesGiveMirroredResults) {
  Random random(11);
  for (int i = 0; i < 5000 && !testing::Test::HasFailure(); ++i) {
    const Shape a = random.shape(), b = random.shape();
    const Pose A = random.pose(0.6), B = random.pose(0.6);
    const Nearest r = nearest(a, A, b, B), m = nearest(b, B, a, A);
    EXPECT_NEAR(r.d, m.d, 1e-12);
    EXPECT_LT(norm(r.n + m.n), 1e-6) << "case " << i;
  }
}

TEST(Distance, IndependentOfTheFrame) {
  Random random(13);
  for (int i = 0; i < 5000 && !testing::Test::HasFailure(); ++i) {
    const Shape a = random.shape(), b = random.shape();
    const Pose A = random.pose(0.6), B = random.pose(0.6), X = random.pose(3);
    const Nearest r = nearest(a, A, b, B), t = nearest(a, X * A, b, X * B);
    EXPECT_NEAR(r.d, t.d, 1e-11);
    EXPECT_LT(norm(X.R * r.n - t.n), 1e-6) << "case " << i;
    EXPECT_LT(norm(X * r.pa - t.pa), 1e-5) << "case " << i;
  }
}

TEST(Distance, DegeneratePosesHaveFiniteUnitNormals) {
  const Shape ball = Shape::sphere(0.2), box = Shape::box({0.3, 0.2, 0.1});
  const Shape capsule = Shape::capsule(0.1, {0, 0, -0.4}, {0, 0, 0.4});
  const Shape point_capsule = Shape::capsule(0.1, {0.2, 0, 0}, {0.2, 0, 0});  // a capsule of length 0
  const Shape shapes[] = {ball, capsule, point_capsule, box};
  const Pose poses[] = {{},             // coincident centres
                        at(0, 0, 0.4),  // centre on a cap
                        at(0.3, 0, 0),
                        at(0, 0.2, 0.1),    // centre on an edge
                        at(0.3, 0.2, 0.1),  // on a corner
                        at(0.2, 0, 0),
                        at(0.4, 0, 0),
                        at(0.6, 0, 0),
                        at(0, 0, 0.2),                         // touching exactly
                        turned({0, 0, 1}, 0.3, {}),            // parallel and turned
                        turned({1, 0, 0}, pi / 2, {}),         // crossing
                        turned({1, 0, 0}, 1e-9, {0, 0.4, 0}),  // almost parallel
                        turned({1, 0, 0}, pi, {0, 0.01, 0})};
  for (const Shape& a : shapes) {
    for (const Shape& b : shapes) {
      for (std::size_t i = 0; i < std::size(poses); ++i) {
        SCOPED_TRACE(testing::Message() << "types " << int(a.type) << " " << int(b.type) << ", pose " << i);
        const Nearest r = nearest(a, poses[i], b, {});
        expect_certified(a, poses[i], b, {}, r, 1e-9);
        const Nearest m = nearest(b, {}, a, poses[i]);
        EXPECT_NEAR(r.d, m.d, 1e-12);
      }
    }
  }
}

TEST(Distance, CapsulesFromParallelToCrossing) {
  const Shape capsule = Shape::capsule(0.1, {-0.5, 0, 0}, {0.5, 0, 0});
  for (double angle = 1e-17; angle < 1; angle *= 3) {
    const Pose B = turned({0, 0, 1}, angle, {0.1, 0.02, 0.35});
    expect_certified(capsule, {}, capsule, B, nearest(capsule, {}, capsule, B), 1e-11);
  }
}

TEST(Distance, BoxesFromParallelToTilted) {
  const Shape box = Shape::box({0.5, 0.4, 0.3});
  for (const double height : {0.7, 0.6, 0.55, 0.3})
    for (double angle = 1e-17; angle < 1; angle *= 3) {
      const Pose B{rotation_about(normalized(Vec3{0.3, 0.5, 0.8}), angle), {0.2, 0.1, height}};
      SCOPED_TRACE(testing::Message() << "height " << height << ", angle " << angle);
      expect_certified(box, B, box, {}, nearest(box, B, box, {}), 1e-9);
    }
}

}  // namespace
}  // namespace ugoki::collision
