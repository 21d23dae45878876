// Distances between all kinds of shapes: comparison of the methods, and the switch between hulls and triangles.

#include "ugoki/collision/pair_distance.h"

#include <gtest/gtest.h>

#include "allocation_count.h"
#include "random_shapes.h"
#include "ugoki/geometry/make_hull.h"

namespace ugoki::collision {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// A mesh made of the surfaces of several boxes. For a point outside of all boxes, the distance is the distance to the nearest box.
struct BoxMesh {
  std::vector<Shape> parts;
  Collider collider;
};

BoxMesh make_box_mesh(const std::vector<Shape>& parts) {
  BoxMesh out;
  out.parts = parts;
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
  for (const Shape& part : parts) {
    const auto first = static_cast<std::int32_t>(vertices.size());
    for (int k = 0; k < 8; ++k) {
      const Vec3& h = part.half_extents;
      vertices.push_back(part.X_BS * Vec3{(k & 1) != 0 ? h.x : -h.x, (k & 2) != 0 ? h.y : -h.y, (k & 4) != 0 ? h.z : -h.z});
    }
    for (const auto& [a, b, c, d] :
         std::vector<std::array<std::int32_t, 4>>{{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}) {
      triangles.push_back({first + a, first + b, first + c});
      triangles.push_back({first + a, first + c, first + d});
    }
  }
  const GeometryPtr surface = make_geometry(vertices, triangles, false, "boxes").value();
  Hull hull = geometry::make_hull(surface->vertices).value();
  const PreparedPtr prepared = make_prepared(*surface, std::move(hull), {}, "boxes").value();
  out.collider = make_collider(Shape::mesh(with_prepared(*surface, prepared)));
  return out;
}

/// A U-shaped mesh, open to the top (+z), 1 m wide.
BoxMesh horseshoe() {
  return make_box_mesh({Shape::box({0.5, 0.1, 0.1}, {Mat3::identity(), {0, 0, 0}}),
                        Shape::box({0.1, 0.1, 0.5}, {Mat3::identity(), {-0.4, 0, 0.4}}),
                        Shape::box({0.1, 0.1, 0.5}, {Mat3::identity(), {0.4, 0, 0.4}})});
}
/// Three perpendicular bars through the origin.
BoxMesh jack(double size) {
  const double thin = 0.1 * size;
  return make_box_mesh({Shape::box({size, thin, thin}), Shape::box({thin, size, thin}), Shape::box({thin, thin, size})});
}

/// Minimum distance over all pairs of boxes.
double brute_force(const BoxMesh& a, const Pose& A, const BoxMesh& b, const Pose& B) {
  double minimum = infinity;
  for (const Shape& p : a.parts)
    for (const Shape& q : b.parts) minimum = std::min(minimum, closed_form_distance(p, A * p.X_BS, q, B * q.X_BS).distance);
  return minimum;
}

TEST(PairDistance, ClosedFormsAgreeWithGilbert) {
  test::Random random(6);
  PairCache cache;
  DistanceWorkspace workspace;
  int overlaps = 0;
  for (int i = 0; i < 5000; ++i) {
    const Collider a = make_collider(random.shape()), b = make_collider(random.shape());
    const Pose A = random.pose(0.7), B = random.pose(0.7);
    const PairDistance d = find_pair_distance(a, A, b, B, infinity, cache, workspace);
    EXPECT_EQ(d.method, DistanceMethod::closed_form);
    EXPECT_TRUE(d.exact);
    GilbertCache fresh;
    const SignedDistance g = signed_distance(a.support, A, b.support, B, fresh, workspace.penetration);
    EXPECT_NEAR(d.distance, g.distance, 1e-8) << i << " types " << int(a.shape.type) << int(b.shape.type);
    EXPECT_LT(norm(d.pa - d.pb - d.n * d.distance), 1e-9);
    overlaps += d.distance < 0 ? 1 : 0;
  }
  EXPECT_GT(overlaps, 500);
}

/// Two boxes, or a capsule and a box, turned relative to each other by 1e-9 ... 1e-4 rad, at gaps from 1e-9 m to 1000 m. The direction n
/// certifies the distance with an error below 1e-9 of the size.
TEST(PairDistance, ClosedFormsAreAccurateForNearlyParallelFaces) {
  test::Random random(31);
  for (int i = 0; i < 40000; ++i) {
    const Shape box = Shape::box({random.in(0.05, 0.5), random.in(0.05, 0.5), random.in(0.05, 0.5)});
    Shape other = i % 3 == 0 ? Shape::capsule(random.in(0.01, 0.1), {0, 0, -0.2}, {0, 0, random.in(0, 0.3)})
                             : Shape::box({random.in(0.05, 0.5), random.in(0.05, 0.5), random.in(0.05, 0.5)});
    other.X_BS = {};
    const double size = norm(box.half_extents) + 0.5;
    const Pose X = random.pose(1);
    Pose Y{rotation_about(random.unit(), std::pow(10, random.in(-9, -4))) * X.R, X.p};
    const Vec3 d = random.below(4) == 0 ? random.unit() : X.R.column(random.below(3));
    const double gap = random.below(4) == 0 ? 0 : random.below(20) == 0 ? 1000 : std::pow(10, random.in(-9, 0));
    Y.p += any_perpendicular(d) * random.in(-0.3, 0.3);
    Y.p += d * (gap + test::support(box, X, d) + test::support(other, Y, -d));
    const PairDistance near = closed_form_distance(box, X, other, Y);
    if (!(near.distance > 0)) continue;
    EXPECT_LT(near.distance - test::separation(box, X, other, Y, near.n), 1e-9 * size) << i << " gap " << gap;
    EXPECT_NEAR(norm(near.pa - near.pb), near.distance, 1e-12 * size + 1e-15 * gap) << i;
    if (HasFailure()) return;
  }
}

TEST(PairDistance, NonConvexMeshesMatchTheirConvexParts) {
  test::Random random(7);
  const BoxMesh a = horseshoe(), b = jack(0.3);
  DistanceWorkspace workspace;
  int by_method[5]{};
  for (int i = 0; i < 60; ++i) {
    PairCache cache;
    Pose A = random.pose(0.1), B = random.pose(i % 3 == 0 ? 3.0 : 0.8);
    const Vec3 drift = random.vec(0.02), spin = random.vec(0.02);
    for (int step = 0; step < 40; ++step) {
      B = {to_matrix(exp_map(spin)) * B.R, B.p + drift};
      const double expected = brute_force(a, A, b, B);
      const PairDistance d = find_pair_distance(a.collider, A, b.collider, B, infinity, cache, workspace);
      ++by_method[static_cast<int>(d.method)];
      if (expected <= 0) continue;
      ASSERT_TRUE(d.exact);
      ASSERT_NEAR(d.distance, expected, 1e-10) << i << " step " << step << " method " << int(d.method);
      ASSERT_LE(d.lower, d.distance);
      ASSERT_LT(norm(d.pa - d.pb - d.n * d.distance), 1e-9);
    }
  }
  EXPECT_GT(by_method[static_cast<int>(DistanceMethod::hulls)], 50);  // hulls are exact where the closest points are vertices of the hulls
  EXPECT_GT(by_method[static_cast<int>(DistanceMethod::bubble)], 500);
}

TEST(PairDistance, ConvexShapeAndMeshMatchTheMeshParts) {
  test::Random random(17);
  const BoxMesh a = horseshoe();
  DistanceWorkspace workspace;
  int compared = 0;
  for (int i = 0; i < 400; ++i) {
    PairCache cache, turned;
    const Collider b = make_collider(random.shape());
    const Pose A = random.pose(0.1), B = random.pose(1.2);
    double expected = infinity;
    for (const Shape& part : a.parts) expected = std::min(expected, closed_form_distance(part, A * part.X_BS, b.shape, B).distance);
    if (expected <= 1e-6) continue;
    ++compared;
    const PairDistance d = find_pair_distance(a.collider, A, b, B, infinity, cache, workspace);
    const PairDistance e = find_pair_distance(b, B, a.collider, A, infinity, turned, workspace);
    ASSERT_NEAR(d.distance, expected, 1e-9) << i << " type " << int(b.shape.type);
    ASSERT_NEAR(e.distance, expected, 1e-9) << i;
    ASSERT_LT(norm(d.pa - d.pb - d.n * d.distance), 1e-8);
    ASSERT_LT(norm(d.n + e.n), 1e-6);
  }
  EXPECT_GT(compared, 100);
}

TEST(PairDistance, OverlappingMeshesHaveADepth) {
  const BoxMesh a = make_box_mesh({Shape::box({0.5, 0.5, 0.5})}), b = make_box_mesh({Shape::box({0.2, 0.2, 0.2})});
  PairCache cache;
  DistanceWorkspace workspace;
  const PairDistance d = find_pair_distance(b.collider, {Mat3::identity(), {0.02, 0.01, 0.65}}, a.collider, {}, infinity, cache, workspace);
  EXPECT_NEAR(d.distance, -0.05, 1e-12);
  EXPECT_NEAR(d.n.z, 1, 1e-12);
}

TEST(PairDistance, DistancesAboveTheCutoffAreOnlyBounded) {
  test::Random random(8);
  const BoxMesh a = horseshoe(), b = jack(0.3);
  PairCache cache;
  DistanceWorkspace workspace;
  int bounds = 0, exact = 0, hulls = 0;
  for (int i = 0; i < 3000; ++i) {
    const Pose A = random.pose(0.1), B = random.pose(1.2);
    const double cutoff = random.in(0.01, 1), expected = brute_force(a, A, b, B);
    if (expected <= 0) continue;
    const PairDistance d = find_pair_distance(a.collider, A, b.collider, B, cutoff, cache, workspace);
    if (d.exact) {
      ++exact;
      ASSERT_NEAR(d.distance, expected, 1e-10);
    } else {
      ++bounds;
      ASSERT_GE(d.lower, cutoff * (1 - 1e-12));
      ASSERT_LE(d.lower, expected + 1e-10);
    }
    hulls += d.method == DistanceMethod::hulls ? 1 : 0;
  }
  EXPECT_GT(bounds, 300);
  EXPECT_GT(exact, 300);
  EXPECT_GT(hulls, 100);
}

TEST(PairDistance, SwitchHasHysteresis) {
  // The jack moves up and down by 2 mm around the height at which the distance of the hulls equals the cutoff.
  const BoxMesh a = horseshoe(), b = jack(0.2);
  PairCache cache;
  DistanceWorkspace workspace;
  const double cutoff = 0.05;
  int changes = 0, steps_near = 0;
  bool last = false;
  test::Random random(1);
  for (int i = 0; i < 2000; ++i) {
    const double height = 0.9 + 0.2 + cutoff + random.in(-0.002, 0.002);  // m: top of the horseshoe + half length of the jack + cutoff
    const PairDistance d = find_pair_distance(b.collider, {Mat3::identity(), {0, 0, height}}, a.collider, {}, cutoff, cache, workspace);
    ASSERT_TRUE(d.method == DistanceMethod::bubble || d.lower >= cutoff);
    changes += cache.near != last ? 1 : 0;
    last = cache.near;
    steps_near += last ? 1 : 0;
  }
  EXPECT_LE(changes, 1);
  EXPECT_GT(steps_near, 1900);
  // For distant shapes the hulls suffice again: the pair switches back from triangles to hulls.
  const PairDistance far = find_pair_distance(b.collider, {Mat3::identity(), {0, 0, 3}}, a.collider, {}, cutoff, cache, workspace);
  EXPECT_FALSE(cache.near);
  EXPECT_GE(far.lower, cutoff);
  EXPECT_EQ(find_pair_distance(b.collider, {Mat3::identity(), {0, 0, 3}}, a.collider, {}, cutoff, cache, workspace).method,
            DistanceMethod::hulls);
}

TEST(PairDistance, BubbleMeasuresInsideTheHull) {
  // The jack is between the arms of the horseshoe, well inside its hull.
  const BoxMesh a = horseshoe(), b = jack(0.2);
  PairCache cache;
  DistanceWorkspace workspace;
  const PairDistance d = find_pair_distance(b.collider, {Mat3::identity(), {0.05, 0, 0.5}}, a.collider, {}, 1, cache, workspace);
  EXPECT_EQ(d.method, DistanceMethod::bubble);
  EXPECT_NEAR(d.distance, 0.05, 1e-12);
  EXPECT_NEAR(d.n.x, -1, 1e-9);
}

TEST(PairDistance, NonFinitePosesGiveNoResult) {
  const BoxMesh a = horseshoe(), b = jack(0.2);
  const Collider ball = make_collider(Shape::sphere(0.1)), drum = make_collider(Shape::cylinder(0.1, 0.2));
  DistanceWorkspace workspace;
  Pose bad;
  bad.p.x = std::nan("");
  for (const auto& [x, y] : std::vector<std::pair<const Collider*, const Collider*>>{
           {&a.collider, &b.collider}, {&ball, &ball}, {&drum, &ball}, {&drum, &drum}}) {
    PairCache cache;
    const PairDistance d = find_pair_distance(*x, bad, *y, {}, infinity, cache, workspace);
    EXPECT_FALSE(d.exact);
    EXPECT_EQ(d.method, DistanceMethod::none);
    EXPECT_EQ(d.lower, -infinity);
    // The pair's cache is still usable after a failed query.
    const PairDistance good = find_pair_distance(*x, {Mat3::identity(), {3, 0, 0}}, *y, {}, infinity, cache, workspace);
    EXPECT_TRUE(good.exact);
    EXPECT_GT(good.distance, 1);
  }
}

TEST(PairDistance, StepsAllocateNothing) {
  const BoxMesh a = horseshoe(), b = jack(0.2);
  const Collider drum = make_collider(Shape::cylinder(0.1, 0.2)), egg = make_collider(Shape::ellipsoid({0.1, 0.2, 0.3}));
  PairCache one, two;
  DistanceWorkspace workspace;
  long before = 0;
  for (int round = 0; round < 2; ++round) {
    before = allocations_so_far();
    for (int i = 0; i < 200; ++i) {
      const Pose X{rotation_about({0, 0, 1}, 0.01 * i), {0, 0, 2.5 - 0.01 * i}};
      (void)find_pair_distance(b.collider, X, a.collider, {}, infinity, one, workspace);
      (void)find_pair_distance(drum, X, egg, {}, infinity, two, workspace);
    }
  }
  EXPECT_EQ(allocations_so_far(), before);
}

}  // namespace
}  // namespace ugoki::collision
