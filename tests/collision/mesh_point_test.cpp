// Nearest points of a surface compared with brute force over all triangles; inside and outside compared with the winding number; depths
// compared with all vertices and with boxes of known depth.

#include "ugoki/collision/mesh_point.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "allocation_count.h"
#include "mesh_trees.h"

namespace ugoki::collision {
namespace {

using test::Mesh;
using test::Random;
using test::tree_of;

/// Winding number of a closed surface about p: its solid angle divided by 4 pi. Source: van Oosterom, Strackee (1983).
double winding(const Mesh& m, const Vec3& p) {
  double sum = 0;
  for (const Triangle& t : m.triangles) {
    const Vec3 a = m.vertices[static_cast<std::size_t>(t[0])] - p, b = m.vertices[static_cast<std::size_t>(t[1])] - p,
               c = m.vertices[static_cast<std::size_t>(t[2])] - p;
    const double la = norm(a), lb = norm(b), lc = norm(c);
    sum += 2 * atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
  }
  return sum / (4 * pi);
}

double min_distance(const Mesh& m, const Vec3& p) {
  double best = 1e300;
  for (const Triangle& t : m.triangles)
    best =
        std::min(best, norm(p - nearest_on_triangle({m.vertices[static_cast<std::size_t>(t[0])], m.vertices[static_cast<std::size_t>(t[1])],
                                                     m.vertices[static_cast<std::size_t>(t[2])]},
                                                    p)
                                    .p));
  return best;
}

TEST(MeshPoint, DistanceAndSideMatchBruteForce) {
  Random random(61);
  BubbleWorkspace workspace;
  for (const double scale : {1e-3, 1.0, 1e3}) {
    const Vec3 moved = random.vec(scale * 100);
    for (Mesh m : {test::bumpy_torus(800), test::torus_knot(800), test::box_mesh({1, 0.5, 0.2})}) {
      m = test::scaled(m, scale, moved);
      const SphereTree tree = tree_of(m);
      std::int32_t warm = -1;
      int inside = 0;
      for (int i = 0; i < 1500; ++i) {
        const auto v = static_cast<std::size_t>(random.below(static_cast<int>(m.vertices.size())));
        const Vec3 p = random.below(3) == 0 ? m.vertices[v] + random.vec(0.1 * scale) : moved + random.vec(1.5 * scale);
        if (random.below(2) == 0) warm = random.below(1000) - 100;
        const SurfacePoint x = find_nearest_point(tree, p, warm, workspace);
        ASSERT_GE(x.triangle, 0);
        ASSERT_NEAR(x.distance, min_distance(m, p), 1e-13 * 100 * scale);
        ASSERT_NEAR(norm(p - x.q), x.distance, 1e-13 * 100 * scale);
        ASSERT_EQ(x.inside, std::fabs(winding(m, p)) > 0.5)
            << "at distance " << x.distance << " of feature " << static_cast<int>(x.feature);
        ASSERT_NEAR(norm(x.n), 1, 1e-12);
        ASSERT_EQ(find_nearest_point(tree, p, warm, workspace, 0.999 * x.distance).triangle, -1);
        inside += x.inside;
      }
      EXPECT_GT(inside, 50);
    }
  }
}

TEST(MeshPoint, OpenMeshesAndInvalidPoints) {
  BubbleWorkspace workspace;
  Mesh open = test::box_mesh({1, 1, 1});
  open.triangles.pop_back();
  std::int32_t warm = -1;
  const SurfacePoint x = find_nearest_point(tree_of(open), {0.5, 0, 0}, warm, workspace);
  EXPECT_NEAR(x.distance, 0.5, 1e-15);
  EXPECT_FALSE(x.inside);
  EXPECT_EQ(x.n, Vec3());
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, inf, -inf, 1e300}) EXPECT_EQ(find_nearest_point(tree_of(open), {0, bad, 0}, warm, workspace).triangle, -1);
  EXPECT_EQ(find_nearest_point({}, {}, warm, workspace).triangle, -1);
}

TEST(MeshPenetration, DepthMatchesDeepestOfAllVertices) {
  Random random(62);
  BubbleWorkspace workspace;
  int penetrating = 0;
  for (int i = 0; i < 60; ++i) {
    const double scale = std::pow(10.0, random.in(-3, 3));
    const Mesh ma = test::scaled(i % 2 == 0 ? test::bumpy_torus(400) : test::torus_knot(500), scale);
    const Mesh mb = test::scaled(i % 3 == 0 ? test::box_mesh({0.5, 0.7, 0.3}) : test::torus_knot(400), scale, random.vec(scale));
    const SphereTree a = tree_of(ma), b = tree_of(mb);
    const Pose A = random.pose(0.3 * scale), B = random.pose(scale);
    double deepest = 0;
    std::int32_t warm = -1;
    for (const Vec3& v : ma.vertices) {
      const SurfacePoint x = find_nearest_point(b, B.inverse() * (A * v), warm, workspace);
      if (x.inside) deepest = std::max(deepest, x.distance);
    }
    for (const Vec3& v : mb.vertices) {
      const SurfacePoint x = find_nearest_point(a, A.inverse() * (B * v), warm, workspace);
      if (x.inside) deepest = std::max(deepest, x.distance);
    }
    const MeshPenetration p = find_penetration(a, A, b, B, workspace);
    ASSERT_NEAR(p.depth, deepest, 1e-13 * scale) << i;
    ASSERT_EQ(p.status, deepest > 0 ? PenetrationStatus::penetrating : PenetrationStatus::apart);
    if (p.depth > 1e-6 * scale) {
      ++penetrating;
      ASSERT_LT(norm(p.pa - p.pb + p.n * p.depth), 1e-13 * scale);
    }
  }
  EXPECT_GT(penetrating, 15);
}

// A small box sinks into a large one: the depth is the vertical depth of the small box's lower corners, for both orders of the boxes.
TEST(MeshPenetration, BoxInBoxHasKnownDepth) {
  const SphereTree floor = tree_of(test::box_mesh({5, 5, 1})), box = tree_of(test::box_mesh({0.3, 0.2, 0.1}));
  BubbleWorkspace workspace;
  for (const double depth : {0.05, 0.01, 1e-4, 1e-6}) {
    const Pose X{rotation_about({0, 0, 1}, 0.3), {0.4, 0.2, 1.1 - depth}};
    const MeshPenetration down = find_penetration(box, X, floor, {}, workspace), up = find_penetration(floor, {}, box, X, workspace);
    EXPECT_NEAR(down.depth, depth, 1e-14);
    EXPECT_NEAR(up.depth, depth, 1e-14);
    EXPECT_LT(norm(down.n - Vec3{0, 0, 1}), 1e-9);
    EXPECT_LT(norm(up.n + Vec3{0, 0, 1}), 1e-9);
  }
  EXPECT_EQ(find_penetration(box, {Mat3::identity(), {0, 0, 1.2}}, floor, {}, workspace).status, PenetrationStatus::apart);
  Mesh open = test::box_mesh({1, 1, 1});
  open.triangles.pop_back();
  EXPECT_EQ(find_penetration(box, {}, tree_of(open), {}, workspace).status, PenetrationStatus::not_closed);
  EXPECT_EQ(find_penetration(box, {}, {}, {}, workspace).status, PenetrationStatus::not_finite);
  const long before = allocations_so_far();
  for (int i = 0; i < 50; ++i) (void)find_penetration(box, {Mat3::identity(), {0, 0.01 * i, 1.05}}, floor, {}, workspace);
  EXPECT_EQ(allocations_so_far(), before);
}

}  // namespace
}  // namespace ugoki::collision
