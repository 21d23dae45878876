// Hulls: consistency of their arrays, the walk to the extreme vertex, and refusal of invalid arrays.

#include <set>

#include "convex_oracles.h"

namespace ugoki::collision {
namespace {

/// Checks that every edge is listed at both ends, that faces are planar with no vertex outside of them, and Euler's formula.
void expect_consistent(const Hull& h) {
  std::set<std::pair<int, int>> edges;
  for (int v = 0; v < static_cast<int>(h.vertices.size()); ++v)
    for (const std::int32_t w : h.neighbours_of(v)) EXPECT_TRUE(edges.insert({v, w}).second);
  for (const auto& [v, w] : edges) EXPECT_TRUE(edges.contains({w, v}));
  if (h.dimension == 3) EXPECT_EQ(static_cast<int>(h.vertices.size()) - static_cast<int>(edges.size() / 2) + h.faces(), 2);
  for (int f = 0; f < h.faces(); ++f) {
    const Vec3 n = h.normals[static_cast<std::size_t>(f)];
    EXPECT_NEAR(norm(n), 1, 1e-12);
    for (const Vec3& v : h.vertices) EXPECT_LE(dot(n, v), h.offsets[static_cast<std::size_t>(f)] + 1e-12 * (1 + norm(v)));
    for (const std::int32_t c : h.face(f))
      EXPECT_NEAR(dot(n, h.vertices[static_cast<std::size_t>(c)]), h.offsets[static_cast<std::size_t>(f)], 1e-11 * (1 + norm(h.centre)));
  }
  for (const Vec3& v : h.vertices) EXPECT_LE(norm(v - h.centre), h.radius * (1 + 1e-15));
}

TEST(Hull, ArraysAreConsistent) {
  test::Random random(5);
  for (const Hull& h : test::some_hulls(random)) expect_consistent(h);
  for (const int n : {17, 100, 1000}) expect_consistent(test::hull_of(test::on_ellipsoid(random, n, {2, 1, 3})));
}

TEST(Hull, MeasuresOfAKnownSolid) {
  std::vector<Vec3> corners;
  for (int i = 0; i < 8; ++i)
    corners.push_back({1 + ((i & 1) != 0 ? 2.0 : 0), -3 + ((i & 2) != 0 ? 4.0 : 0), 5 + ((i & 4) != 0 ? 6.0 : 0)});
  for (int i = 0; i < 8; ++i) corners.push_back(corners[static_cast<std::size_t>(i)]);  // duplicates
  corners.push_back({2, -1, 8});                                                        // a point inside
  const Hull h = test::hull_of(corners);
  EXPECT_EQ(h.vertices.size(), 8u);
  EXPECT_EQ(h.faces(), 6);
  EXPECT_EQ(h.corners.size(), 24u);
  EXPECT_NEAR(h.volume, 48, 1e-12);
  EXPECT_NEAR(norm(h.centre - Vec3{2, -1, 8}), 0, 1e-13);
  EXPECT_NEAR(h.radius, std::sqrt(1 + 4 + 9), 1e-13);
}

TEST(Hull, StoredArraysGiveTheSameHull) {
  test::Random random(6);
  for (const Hull& h : test::some_hulls(random)) {
    const Result<Hull> again = assemble_hull(h.vertices, h.first_corner, h.corners);
    ASSERT_TRUE(again.has_value()) << again.error().text();
    EXPECT_EQ(again->hash, h.hash);
    EXPECT_EQ(again->neighbours, h.neighbours);
    EXPECT_EQ(again->walk.seeds, h.walk.seeds);
    EXPECT_EQ(again->dimension, h.dimension);
    Hull moved = h;
    moved.vertices[0].x += 1e-3;
    const Result<Hull> other = assemble_hull(moved.vertices, h.first_corner, h.corners);
    if (other) EXPECT_NE(other->hash, h.hash);
  }
}

TEST(Hull, WalkFindsTheExtremeVertexFromAnywhere) {
  test::Random random(7);
  std::vector<Hull> hulls = test::some_hulls(random);
  hulls.push_back(test::hull_of(test::on_ellipsoid(random, 3000, {1, 0.2, 0.01})));
  std::vector<Vec3> cone{{0, 0, 1}};  // its tip has 200 neighbours
  for (int i = 0; i < 200; ++i) cone.push_back({std::cos(i * pi / 100), std::sin(i * pi / 100), 0});
  hulls.push_back(test::hull_of(cone));
  for (const Hull& h : hulls) {
    const auto n = static_cast<int>(h.vertices.size());
    for (int i = 0; i < 2000; ++i) {
      const Vec3 d = random.unit();
      double best = -1e300;
      for (const Vec3& v : h.vertices) best = std::max(best, dot(d, v));
      for (const std::int32_t start : {random.below(n), static_cast<int>(seed_vertex(h, d))}) {
        const std::int32_t v = find_extreme_vertex(h, d, start);
        ASSERT_NEAR(dot(d, h.vertices[static_cast<std::size_t>(v)]), best, 1e-15) << n << " vertices";
      }
      Hull bare;
      if (i < 20) {
        bare.vertices = h.vertices;
        EXPECT_NEAR(dot(d, h.vertices[static_cast<std::size_t>(find_extreme_vertex(bare, d, 0))]), best, 1e-15);
      }
    }
  }
}

TEST(Hull, RefusesInvalidArrays) {
  test::Random random(8);
  const Hull good = test::hull_of(test::on_ellipsoid(random, 30, {1, 1, 1}));
  const auto refused = [&](auto change) {
    Hull h = good;
    change(h);
    const Result<Hull> out = assemble_hull(h.vertices, h.first_corner, h.corners);
    EXPECT_FALSE(out.has_value());
    if (!out) EXPECT_FALSE(out.error().text().empty());
  };
  refused([](Hull& h) { h.corners[5] = 30; });
  refused([](Hull& h) { h.corners[5] = -1; });
  refused([](Hull& h) { std::swap(h.corners[0], h.corners[1]); });
  refused([](Hull& h) { h.first_corner[3] = 2000000000; });
  refused([](Hull& h) { h.first_corner[3] = h.first_corner[2]; });
  refused([](Hull& h) { h.first_corner.pop_back(); });
  refused([](Hull& h) { h.vertices[3] = h.vertices[3] * 0.5; });  // a dent
  refused([](Hull& h) { h.vertices[3].y = std::nan(""); });
  refused([](Hull& h) { h.vertices.push_back({0, 0, 0}); });
  refused([](Hull& h) { h = {}; });
  refused([](Hull& h) {
    for (std::size_t f = 0; f + 1 < h.first_corner.size(); ++f)
      std::reverse(h.corners.begin() + h.first_corner[f], h.corners.begin() + h.first_corner[f + 1]);
  });
}

}  // namespace
}  // namespace ugoki::collision
