// Distance between a convex shape and a mesh, compared with Gilbert's method for every triangle, and with the distance between two meshes.

#include "ugoki/collision/convex_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "allocation_count.h"
#include "mesh_trees.h"
#include "ugoki/collision/triangle_distance.h"

namespace ugoki::collision {
namespace {

using test::Mesh;
using test::Random;
using test::tree_of;

Support random_shape(Random& random, double scale) {
  const auto r = [&] { return scale * random.in(0.05, 0.4); };
  switch (random.below(5)) {
    case 0: return Support::sphere(r());
    case 1: return Support::capsule(0.3 * r(), r());
    case 2: return Support::cylinder(r(), r());
    case 3: return Support::ellipsoid({r(), r(), r()});
    default: return Support::box({r(), r(), random.below(2) == 0 ? r() : 1e-4 * scale}, random.below(2) == 0 ? 0 : 0.1 * r());
  }
}

double brute_force(const Support& s, const Pose& A, const Mesh& m, const Pose& B) {
  double best = std::numeric_limits<double>::infinity();
  for (const Triangle& t : m.triangles) {
    Hull h;
    h.dimension = 2;
    for (const std::int32_t v : t) h.vertices.push_back(m.vertices[static_cast<std::size_t>(v)]);
    h.centre = (h.vertices[0] + h.vertices[1] + h.vertices[2]) / 3;
    for (const Vec3& v : h.vertices) h.radius = std::max(h.radius, norm(v - h.centre));
    GilbertCache cold;
    const GilbertResult d = gilbert_distance(s, A, Support::of(h), B, cold, {.tolerance = 1e-12});
    best = std::min(best, d.status == GilbertStatus::touching ? 0.0 : std::max(d.distance, 0.0));
  }
  return best;
}

TEST(ConvexMesh, MatchesBruteForceOverTriangles) {
  Random random(71);
  ConvexMeshWorkspace workspace;
  int apart = 0, touching = 0;
  for (int i = 0; i < 400; ++i) {
    const double scale = std::pow(10.0, random.in(-3, 3)), far = random.below(3) == 0 ? 1000 : 0;
    const Mesh m = test::scaled(i % 3 == 0   ? test::soup(random, 1 + random.below(60), 1)
                                : i % 3 == 1 ? test::bumpy_torus(150)
                                             : test::torus_knot(200),
                                scale, random.vec(scale));
    const SphereTree tree = tree_of(m);
    const Support s = random_shape(random, scale);
    Pose A = random.pose(scale * random.in(0.1, 3)), B = random.pose(scale);
    A.p.x += far;
    B.p.x += far;
    const double expected = brute_force(s, A, m, B), tolerance = 1e-10 * scale + 1e-13 * far;
    ConvexMeshCache cache;
    if (random.below(2) == 0) cache.triangle = random.below(300) - 20;
    const BubbleDistance d = find_distance(s, A, tree, B, cache, workspace);
    ASSERT_NEAR(d.distance, expected, tolerance) << "case " << i << ", kind " << static_cast<int>(s.kind);
    ASSERT_LE(d.lower, expected + tolerance);
    ASSERT_GE(d.lower, expected - tolerance);
    if (d.distance > 0) {
      ASSERT_LT(norm(d.pa - d.pb - d.n * d.distance), tolerance);
    }
    ASSERT_EQ(d.nearest.b, cache.triangle);
    const BubbleDistance warm = find_distance(s, A, tree, B, cache, workspace);
    ASSERT_NEAR(warm.distance, d.distance, tolerance);
    for (const double e : {0.1, 1.0}) {
      ConvexMeshCache cold;
      const BubbleDistance rough = find_distance(s, A, tree, B, cold, workspace, {.relative_error = e});
      ASSERT_LE(rough.distance, expected * (1 + e) + tolerance);
      ASSERT_LE(rough.lower, expected + tolerance);
      ASSERT_GE(rough.lower * (1 + e), rough.distance - tolerance);
    }
    for (const double part : {0.5, 0.99, 1.01}) {
      ConvexMeshCache cold;
      const BubbleDistance d2 = find_distance(s, A, tree, B, cold, workspace, {.farthest = part * expected});
      if (part > 1 && expected > 10 * tolerance) {
        ASSERT_NEAR(d2.distance, expected, tolerance);
      } else {
        ASSERT_EQ(d2.status, expected > 0 || s.kind != SupportKind::point ? BubbleStatus::beyond : d2.status);
      }
    }
    (expected > 0 ? apart : touching) += 1;
  }
  EXPECT_GT(apart, 200);
  EXPECT_GT(touching, 30);
}

// A solid box and the mesh of a box have the same distance from another mesh, unless one contains the other.
TEST(ConvexMesh, MatchesTheMeshOfTheSameShape) {
  Random random(72);
  ConvexMeshWorkspace workspace;
  BubbleWorkspace bubble;
  const Vec3 half{0.3, 0.2, 0.1};
  const SphereTree box = tree_of(test::box_mesh(half)), torus = tree_of(test::bumpy_torus(2000));
  ConvexMeshCache cache;
  TrianglePair pair;
  for (int i = 0; i < 300; ++i) {
    const Pose A{random.pose(1).R, {1.5 + 0.5 * sin(0.03 * i), 0.2 * i * 0.01, 0.1}};
    const double solid = find_distance(Support::box(half), A, torus, {}, cache, workspace).distance;
    const double mesh = find_distance(box, A, torus, {}, pair, bubble).distance;
    ASSERT_NEAR(solid, mesh, 1e-11) << i;
  }
}

TEST(ConvexMesh, AllocatesNothingAfterWarmUpAndReportsInvalidInput) {
  const SphereTree torus = tree_of(test::bumpy_torus(2000));
  ConvexMeshWorkspace workspace;
  ConvexMeshCache cache;
  const auto pose = [](int i) { return Pose{rotation_about({1, 0, 0}, 0.02 * i), {1.7, 0.005 * i, 0.1}}; };
  for (int i = 0; i < 100; ++i) (void)find_distance(Support::box({0.2, 0.1, 0.1}), pose(i), torus, {}, cache, workspace);
  const long before = allocations_so_far();
  for (int i = 0; i < 100; ++i) (void)find_distance(Support::box({0.2, 0.1, 0.1}), pose(i), torus, {}, cache, workspace);
  EXPECT_EQ(allocations_so_far(), before);
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, inf, 1e10}) {
    EXPECT_EQ(find_distance(Support::sphere(bad), {}, torus, {}, cache, workspace).status, BubbleStatus::not_finite);
    EXPECT_EQ(find_distance(Support::box({1, bad, 1}), {}, torus, {}, cache, workspace).status, BubbleStatus::not_finite);
    EXPECT_EQ(find_distance(Support::sphere(1), {Mat3::identity(), {0, bad, 0}}, torus, {}, cache, workspace).status,
              BubbleStatus::not_finite);
  }
  EXPECT_EQ(find_distance(Support::half_space(), {}, torus, {}, cache, workspace).status, BubbleStatus::not_finite);
  EXPECT_EQ(find_distance(Support::sphere(1), {}, SphereTree{}, {}, cache, workspace).status, BubbleStatus::not_finite);
}

}  // namespace
}  // namespace ugoki::collision
