// Sphere trees: every bound contains its triangles, the splits are even, invalid meshes and damaged bytes are refused.

#include "ugoki/collision/sphere_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>

#include "mesh_trees.h"
#include "ugoki/base/hash.h"
#include "ugoki/collision/triangle_distance.h"

namespace ugoki::collision {
namespace {

using test::Mesh;
using test::Random;
using test::tree_of;

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

Vec3 lane(const float (*v)[block_lanes], int i) {
  return {static_cast<double>(v[0][i]), static_cast<double>(v[1][i]), static_cast<double>(v[2][i])};
}

/// Checks that the bounds in lane i of a block contain all triangles in the lane's subtree, and appends the triangles' indices to `below`.
void check_below(const SphereTree& tree, std::int32_t block, int i, std::vector<std::int32_t>& below) {
  const BoundBlock& b = tree.blocks[at(block)];
  std::vector<std::int32_t> mine;
  if (b.child[i] < 0) {
    mine.push_back(-1 - b.child[i]);
  } else {
    for (int k = 0; k < tree.blocks[at(b.child[i])].count; ++k) check_below(tree, b.child[i], k, mine);
  }
  const Vec3 sphere = lane(b.sphere, i), box = lane(b.box, i), x = lane(b.axis[0], i), y = lane(b.axis[1], i), z = cross(x, y);
  double on_surface = 1e300;
  for (const std::int32_t t : mine) {
    const TriangleCorners corners{tree.corner(t, 0), tree.corner(t, 1), tree.corner(t, 2)};
    on_surface = std::min(on_surface, norm(nearest_on_triangle(corners, sphere).p - sphere));
    for (const Vec3& v : corners) {
      ASSERT_LE(norm(v - sphere), static_cast<double>(b.radius[i]));
      ASSERT_LE(std::fabs(dot(v - box, x)), static_cast<double>(b.half[0][i]));
      ASSERT_LE(std::fabs(dot(v - box, y)), static_cast<double>(b.half[1][i]));
      ASSERT_LE(std::fabs(dot(v - box, z)), static_cast<double>(b.half[2][i]));
    }
  }
  ASSERT_LE(on_surface, 1e-6 * tree.radius) << "the centre of a sphere must be on the surface";
  below.insert(below.end(), mine.begin(), mine.end());
}

TEST(SphereTree, BoundsContainTheirTriangles) {
  Random random(41);
  std::vector<Mesh> meshes{test::bumpy_torus(2000), test::torus_knot(900), test::box_mesh({1, 1e-4, 1}),
                           test::scaled(test::torus_knot(500), 1e-3), test::scaled(test::bumpy_torus(300), 1e3, {1000, -1000, 500})};
  for (const int n : {1, 2, 7, 8, 9, 63, 64, 65, 100, 513, 4097}) meshes.push_back(test::soup(random, n, 1));
  for (const Mesh& m : meshes) {
    const SphereTree tree = tree_of(m);
    std::vector<std::int32_t> all;
    check_below(tree, 0, 0, all);
    ASSERT_EQ(all.size(), m.triangles.size());
    std::sort(all.begin(), all.end());
    for (std::size_t i = 0; i < all.size(); ++i) ASSERT_EQ(all[i], static_cast<std::int32_t>(i));
    for (std::size_t i = 0; i < tree.triangles.size(); ++i) {
      const Triangle &t = tree.triangles[i], &s = m.triangles[at(tree.source[i])];
      for (std::size_t k = 0; k < 3; ++k) {
        ASSERT_NE(std::find(s.begin(), s.end(), tree.vertex_source[at(t[k])]), s.end());
        ASSERT_LE(norm(tree.vertices[at(t[k])] + tree.centre - m.vertices[at(tree.vertex_source[at(t[k])])]),
                  1e-15 * (norm(tree.centre) + tree.radius));
        ASSERT_LE(norm(tree.vertices[at(t[k])]), tree.radius);
      }
    }
  }
}

TEST(SphereTree, BoundsAreTightAndBlocksAreFull) {
  const SphereTreeReport r = report_of(tree_of(test::bumpy_torus(20000)));
  ASSERT_GE(r.spheres_at.size(), 5U);
  for (std::size_t d = 1; d < r.spheres_at.size(); ++d) {
    EXPECT_GE(r.spheres_at[d], r.spheres_at[d - 1]);
    EXPECT_LT(r.mean_radius[d], r.mean_radius[d - 1]);
    EXPECT_LT(r.mean_overlap[d], 0.7);
  }
  EXPECT_LT(r.spheres, r.triangles * 5 / 4);
  EXPECT_LT(r.bytes, r.triangles * 250);
}

TEST(SphereTree, ClosedMeshesAreOrientedOutwards) {
  const SphereTree torus = tree_of(test::bumpy_torus(1000));
  EXPECT_TRUE(torus.closed);
  for (std::size_t i = 0; i < torus.triangles.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const Triangle &t = torus.triangles[i], &other = torus.triangles[at(torus.across[i][k])];
      const std::int32_t from = t[k], to = t[(k + 1) % 3];
      bool turned = false;
      for (std::size_t j = 0; j < 3; ++j) turned = turned || (other[j] == to && other[(j + 1) % 3] == from);
      ASSERT_TRUE(turned);
    }
  Mesh box = test::box_mesh({1, 2, 3});
  for (Triangle& t : box.triangles) std::swap(t[0], t[1]);  // oriented inwards
  const SphereTree turned = tree_of(box);
  ASSERT_TRUE(turned.closed);
  for (std::size_t v = 0; v < turned.vertices.size(); ++v) {
    const Vec3 n = turned.vertex_normals[v], p = turned.vertices[v];
    EXPECT_NEAR(norm(n), 1, 1e-14);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(n[k], (p[k] > 0 ? 1 : -1) / std::sqrt(3.0), 1e-14);
  }
  box.triangles.pop_back();
  EXPECT_FALSE(tree_of(box).closed);
}

TEST(SphereTree, InvalidMeshesAreRefusedWithAMessage) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  const auto error = [](const Mesh& m) {
    const Result<SphereTree> made = make_sphere_tree(m.vertices, m.triangles, "hand.stl");
    return made ? std::string() : made.error().text();
  };
  EXPECT_NE(error({}).find("no triangle"), std::string::npos);
  for (const double bad : {nan, inf, -inf, 2e6}) {
    Mesh m = test::box_mesh({1, 1, 1});
    m.vertices[3].y = bad;
    EXPECT_NE(error(m).find("hand.stl"), std::string::npos);
    EXPECT_NE(error(m).find("Vertex 3"), std::string::npos);
  }
  for (const std::int32_t bad : {-1, 8, std::numeric_limits<std::int32_t>::max(), std::numeric_limits<std::int32_t>::min()}) {
    Mesh m = test::box_mesh({1, 1, 1});
    m.triangles[5][1] = bad;
    EXPECT_NE(error(m).find("refers to vertex"), std::string::npos);
  }
  // All vertices at one point, or on a line: the tree is built although there is no area and no spread.
  Mesh point, line;
  for (int i = 0; i < 100; ++i) {
    point.vertices.push_back({1, 2, 3});
    line.vertices.push_back({0.1 * i, 0, 0});
    if (i >= 2) {
      point.triangles.push_back({i - 2, i - 1, i});
      line.triangles.push_back({i - 2, i - 1, i});
    }
  }
  for (const Mesh& m : {point, line}) {
    std::vector<std::int32_t> all;
    check_below(tree_of(m), 0, 0, all);
    EXPECT_EQ(all.size(), m.triangles.size());
  }
}

TEST(SphereTree, BytesRoundTrip) {
  for (const Mesh& m : {test::bumpy_torus(700), test::box_mesh({1, 1, 1})}) {
    const SphereTree tree = tree_of(m);
    const std::vector<std::uint8_t> bytes = write_bytes(tree);
    const Result<SphereTree> back = read_sphere_tree(bytes);
    ASSERT_TRUE(back.has_value()) << back.error().text();
    EXPECT_EQ(write_bytes(*back), bytes);
    EXPECT_EQ(back->triangles, tree.triangles);
    EXPECT_EQ(back->closed, tree.closed);
  }
}

/// Recomputes the checksum, so that the checks after the checksum are tested.
void repair(std::vector<std::uint8_t>& bytes) {
  Hash64 hash;
  hash.add_bytes(bytes.data() + 16, bytes.size() - 16);
  const std::uint64_t sum = hash.value();
  std::copy_n(reinterpret_cast<const std::uint8_t*>(&sum), 8, bytes.begin() + 8);
}

TEST(SphereTree, DamagedBytesAreRefused) {
  Random random(42);
  const SphereTree tree = tree_of(test::box_mesh({1, 1, 1}));
  const std::vector<std::uint8_t> bytes = write_bytes(tree);
  for (std::size_t n = 0; n < bytes.size(); n += 7) EXPECT_FALSE(read_sphere_tree(std::span(bytes).first(n)).has_value());
  int accepted = 0;
  for (int i = 0; i < 20000; ++i) {
    std::vector<std::uint8_t> broken = bytes;
    const auto where = static_cast<std::size_t>(random.below(static_cast<int>(bytes.size())));
    broken[where] = static_cast<std::uint8_t>(broken[where] ^ (1 << random.below(8)));
    ASSERT_FALSE(read_sphere_tree(broken).has_value()) << where;
    if (where >= 16) {
      repair(broken);
      const Result<SphereTree> read = read_sphere_tree(broken);
      if (!read) continue;
      ++accepted;  // only a value changed: the tree can still be searched and contains every triangle once
      std::vector<int> leaves(read->triangles.size(), 0);
      for (const BoundBlock& b : read->blocks)
        for (int k = 0; k < b.count; ++k)
          if (b.child[k] < 0) ++leaves.at(at(-1 - b.child[k]));
      ASSERT_EQ(std::ranges::count(leaves, 1), static_cast<std::ptrdiff_t>(leaves.size())) << where;
    }
  }
  EXPECT_GT(accepted, 1000);
}

// Builds a tree with nearly the maximum number of triangles. A mesh with more than the maximum is refused.
TEST(Slow_SphereTree, MaximumSizeIsAcceptedAndLargerSizesAreRefused) {
  const SphereTree tree = tree_of(test::bumpy_torus(1'990'000));
  EXPECT_GT(tree.triangles.size(), 1'900'000U);
  EXPECT_LT(report_of(tree).bytes, tree.triangles.size() * 250);
  const Mesh huge = test::bumpy_torus(5'000'000);
  const Result<SphereTree> made = make_sphere_tree(huge.vertices, huge.triangles, "city.stl");
  ASSERT_FALSE(made.has_value());
  EXPECT_NE(made.error().text().find("at most 2000000"), std::string::npos) << made.error().text();
}

}  // namespace
}  // namespace ugoki::collision
