// Exact distances between meshes, compared with brute force over all pairs of triangles. fcl_mesh_test.cpp compares them with FCL.

#include "ugoki/collision/bubble.h"

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

std::vector<TriangleCorners> placed(const Mesh& m, const Pose& X) {
  std::vector<TriangleCorners> out;
  for (const Triangle& t : m.triangles) {
    TriangleCorners c;
    for (std::size_t k = 0; k < 3; ++k) c[k] = X * m.vertices[static_cast<std::size_t>(t[k])];
    out.push_back(c);
  }
  return out;
}

std::vector<double> all_distances(const Mesh& a, const Pose& A, const Mesh& b, const Pose& B) {
  std::vector<double> out;
  const std::vector<TriangleCorners> pa = placed(a, A), pb = placed(b, B);
  for (const TriangleCorners& s : pa)
    for (const TriangleCorners& t : pb) out.push_back(triangle_distance(s, t).distance);
  return out;
}

double distance_from(const std::vector<TriangleCorners>& mesh, const Vec3& p) {
  double best = 1e300;
  for (const TriangleCorners& t : mesh) best = std::min(best, norm(nearest_on_triangle(t, p).p - p));
  return best;
}

struct Case {
  Mesh a, b;
  Pose A, B;
  double scale;  // maximum coordinate in the computation, for tolerances
};

/// Two small meshes of random kind and size: far apart, near, touching or piercing; sometimes far from the origin.
Case random_case(Random& random) {
  const auto mesh = [&] {
    switch (random.below(5)) {
      case 0: return test::torus_knot(60 + random.below(100));
      case 1: return test::bumpy_torus(60 + random.below(100));
      case 2: return test::box_mesh({random.in(0.1, 1), random.in(0.1, 1), random.below(2) == 0 ? 1e-4 : 0.5});
      case 3: return test::soup(random, 1 + random.below(3), 0.5);
      default: return test::soup(random, 1 + random.below(80), 1);
    }
  };
  const double scale = std::pow(10.0, random.in(-3, 3)), far = random.below(3) == 0 ? 1000 : 0;
  Case c{mesh(), mesh(), {}, {}, 0};
  const Vec3 inside_offset = random.below(3) == 0 ? random.vec(1000) : Vec3{};
  c.a = test::scaled(c.a, scale, inside_offset);
  c.b = test::scaled(c.b, scale);
  c.A = random.pose(0.2 * scale);
  c.B = random.pose((random.below(2) == 0 ? 1.0 : 4.0) * scale);
  c.A.p = c.A.p - c.A.R * inside_offset + Vec3{far, 0, 0};
  c.B.p += Vec3{far, 0, 0};
  c.scale = 5 * scale + far + norm(inside_offset);
  return c;
}

class EachWidth : public ::testing::TestWithParam<BubbleWidth> {
 protected:
  void SetUp() override {
    if (!use_bubble_width(GetParam())) GTEST_SKIP() << "this processor does not support this SIMD width";
  }
};
INSTANTIATE_TEST_SUITE_P(Bubble, EachWidth, ::testing::Values(BubbleWidth::plain, BubbleWidth::avx2, BubbleWidth::avx512));

TEST_P(EachWidth, DistanceMatchesBruteForce) {
  Random random(51);
  BubbleWorkspace workspace;
  int apart = 0, meeting = 0;
  for (int i = 0; i < 300; ++i) {
    const Case c = random_case(random);
    const SphereTree a = tree_of(c.a), b = tree_of(c.b);
    const double expected = std::ranges::min(all_distances(c.a, c.A, c.b, c.B)), tolerance = 1e-14 * c.scale;
    TrianglePair warm;
    if (random.below(2) == 0) warm = {random.below(200) - 50, random.below(200) - 50};  // start from invalid or arbitrary triangles
    const BubbleDistance d = find_distance(a, c.A, b, c.B, warm, workspace);
    ASSERT_NEAR(d.distance, expected, tolerance) << "case " << i;
    ASSERT_EQ(d.lower, d.distance);
    ASSERT_EQ(d.status, d.distance > 0 ? BubbleStatus::separated : BubbleStatus::touching);
    ASSERT_LT(distance_from(placed(c.a, c.A), d.pa), tolerance) << i;
    ASSERT_LT(distance_from(placed(c.b, c.B), d.pb), tolerance) << i;
    ASSERT_NEAR(norm(d.pa - d.pb), d.distance, tolerance);
    if (d.distance > 0) {
      ASSERT_NEAR(norm(d.n), 1, 1e-14);
    }
    if (d.distance > 1e-6 * c.scale) {
      ASSERT_NEAR(dot(d.n, d.pa - d.pb), d.distance, tolerance);
    }
    ASSERT_EQ(warm, d.nearest);
    (expected > tolerance ? apart : meeting) += 1;
    // A warm start from the result of the same query gives the same distance.
    const BubbleDistance again = find_distance(a, c.A, b, c.B, warm, workspace);
    ASSERT_EQ(again.distance, d.distance);
    ASSERT_LE(again.triangle_tests, d.triangle_tests + 8);
  }
  EXPECT_GT(apart, 100);
  EXPECT_GT(meeting, 50);
}

TEST_P(EachWidth, RelativeErrorAndFarthestAreRespected) {
  Random random(52);
  BubbleWorkspace workspace;
  int fewer = 0, beyond = 0;
  for (int i = 0; i < 200; ++i) {
    const Case c = random_case(random);
    const SphereTree a = tree_of(c.a), b = tree_of(c.b);
    TrianglePair cold;
    const BubbleDistance exact = find_distance(a, c.A, b, c.B, cold, workspace);
    for (const double e : {1e-3, 0.1, 0.5, 2.0}) {
      TrianglePair warm;
      const BubbleDistance d = find_distance(a, c.A, b, c.B, warm, workspace, {.relative_error = e});
      ASSERT_GE(d.distance, exact.distance * (1 - 1e-14));
      ASSERT_LE(d.distance, exact.distance * (1 + e) * (1 + 1e-14)) << "case " << i << ", error " << e;
      ASSERT_LE(d.lower, exact.distance * (1 + 1e-14));
      ASSERT_GE(d.lower * (1 + e), d.distance * (1 - 1e-14));
      ASSERT_NEAR(norm(d.pa - d.pb), d.distance, 1e-14 * c.scale);
      fewer += d.bound_tests < exact.bound_tests;
    }
    for (const double part : {0.5, 0.999, 1.001, 2.0}) {
      TrianglePair warm = random.below(2) == 0 ? cold : TrianglePair{};
      const BubbleDistance d = find_distance(a, c.A, b, c.B, warm, workspace, {.farthest = part * exact.distance});
      if (part > 1 && exact.distance > 0) {
        ASSERT_EQ(d.distance, exact.distance);
      } else {
        ASSERT_EQ(d.status, BubbleStatus::beyond);
        ASSERT_EQ(d.lower, part * exact.distance);
        ++beyond;
      }
    }
  }
  EXPECT_GT(fewer, 100);
  EXPECT_GT(beyond, 100);
}

TEST_P(EachWidth, PairsWithinMarginMatchBruteForce) {
  Random random(53);
  BubbleWorkspace workspace;
  std::vector<TriangleContact> out(40000);
  std::size_t max_count = 0;
  for (int i = 0; i < 80; ++i) {
    const Case c = random_case(random);
    const SphereTree a = tree_of(c.a), b = tree_of(c.b);
    std::vector<double> all = all_distances(c.a, c.A, c.b, c.B), sorted = all;
    std::ranges::sort(sorted);
    // The margin is half way between two distances, so that rounding does not matter.
    const auto k = static_cast<std::size_t>(random.below(static_cast<int>(std::min<std::size_t>(sorted.size() - 1, 2000)) + 1));
    const double margin = k + 1 < sorted.size() ? 0.5 * (sorted[k] + sorted[k + 1]) : 2 * sorted[k] + 1;
    const auto expected = static_cast<std::size_t>(std::ranges::count_if(all, [&](double d) { return d < margin; }));
    if (k + 1 < sorted.size() && sorted[k + 1] - sorted[k] < 1e-12 * c.scale) continue;
    const PairsFound found = find_pairs_within(a, c.A, b, c.B, margin, out, workspace);
    ASSERT_EQ(found.status, BubbleStatus::separated);
    ASSERT_TRUE(found.complete);
    ASSERT_EQ(found.count, expected) << i;
    std::vector<TrianglePair> pairs;
    for (std::size_t j = 0; j < found.count; ++j) {
      const TriangleContact& t = out[j];
      const auto ia = static_cast<std::size_t>(a.source[static_cast<std::size_t>(t.pair.a)]),
                 ib = static_cast<std::size_t>(b.source[static_cast<std::size_t>(t.pair.b)]);
      ASSERT_NEAR(t.distance, all[ia * c.b.triangles.size() + ib], 1e-14 * c.scale);
      ASSERT_NEAR(norm(t.pa - t.pb), t.distance, 1e-13 * c.scale);
      pairs.push_back(t.pair);
    }
    std::ranges::sort(pairs, [](const TrianglePair& x, const TrianglePair& y) { return x.a != y.a ? x.a < y.a : x.b < y.b; });
    ASSERT_EQ(std::ranges::adjacent_find(pairs), pairs.end()) << "a pair was found twice";
    max_count = std::max(max_count, found.count);
    if (expected > 1) {
      const PairsFound part = find_pairs_within(a, c.A, b, c.B, margin, std::span(out).first(expected - 1), workspace);
      ASSERT_EQ(part.count, expected - 1);
      ASSERT_FALSE(part.complete);
      ASSERT_TRUE(find_pairs_within(a, c.A, b, c.B, margin, std::span(out).first(expected), workspace).complete);
    }
  }
  EXPECT_GT(max_count, 500U);
}

/// Pose of a knot that moves inside the hole of a torus.
Pose knot_pose(int step) {
  const double t = 0.01 * step;
  return {rotation_about({0, 0, 1}, 2 * t) * rotation_about({1, 0, 0}, 3 * t), {0.06 * sin(5 * t), 0.06 * cos(7 * t), 0.06 * sin(11 * t)}};
}

TEST(Bubble, SameBitsInEveryRunAndWidth) {
  const SphereTree a = tree_of(test::bumpy_torus(3000)), b = tree_of(test::torus_knot(3000));
  std::vector<std::vector<double>> runs;
  for (const BubbleWidth width : {BubbleWidth::plain, BubbleWidth::plain, BubbleWidth::avx2, BubbleWidth::avx512}) {
    if (!use_bubble_width(width)) continue;
    BubbleWorkspace workspace;
    TrianglePair warm;
    std::vector<double> run;
    for (int i = 0; i < 300; ++i) {
      const BubbleDistance d = find_distance(a, {}, b, knot_pose(i), warm, workspace);
      run.insert(run.end(), {d.distance, d.pa.x, d.pb.y, d.n.z, static_cast<double>(d.nearest.a)});
    }
    runs.push_back(run);
  }
  for (const auto& run : runs) EXPECT_EQ(run, runs.front());
}

TEST(Bubble, AllocatesNothingAfterWarmUp) {
  const SphereTree a = tree_of(test::bumpy_torus(3000)), b = tree_of(test::torus_knot(3000));
  BubbleWorkspace workspace;
  TrianglePair warm;
  std::vector<TriangleContact> out(500);
  (void)find_distance(a, {}, b, knot_pose(0), warm, workspace);
  (void)find_pairs_within(a, {}, b, knot_pose(0), 0.2, out, workspace);
  const long before = allocations_so_far();
  double sum = 0;
  for (int i = 0; i < 300; ++i) {
    sum += find_distance(a, {}, b, knot_pose(i), warm, workspace).distance;
    sum += find_pairs_within(a, {}, b, knot_pose(i), 0.2, out, workspace).count > 0 ? 1 : 0;
  }
  EXPECT_EQ(allocations_so_far(), before);
  EXPECT_GT(sum, 10);
}

// Moving meshes in a hole, near each other and far apart: a warm start gives the same distance as a cold start, with fewer tests.
TEST_P(EachWidth, WarmStartNeedsLessWorkInMotion) {
  const SphereTree a = tree_of(test::bumpy_torus(6000)), b = tree_of(test::torus_knot(6000));
  BubbleWorkspace workspace;
  for (const Vec3& location : {Vec3{0, 0, 0}, Vec3{1.9, 0, 0}, Vec3{1, 0, 0.85}, Vec3{4, 1, 2}, Vec3{-30, 3, 8}}) {
    TrianglePair warm;
    long with = 0, without = 0;
    for (int i = 0; i < 80; ++i) {
      Pose X = knot_pose(i);
      X.p += location;
      TrianglePair cold;
      const BubbleDistance d = find_distance(a, {}, b, X, cold, workspace), w = find_distance(a, {}, b, X, warm, workspace);
      ASSERT_NEAR(d.distance, w.distance, 1e-14 * (1 + norm(location))) << "step " << i;
      without += d.bound_tests;
      if (i > 0) with += w.bound_tests;
    }
    EXPECT_LT(with, without);
  }
}

TEST(Bubble, InvalidPosesAndEmptyTreesAreReported) {
  const SphereTree a = tree_of(test::box_mesh({1, 1, 1})), none;
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  BubbleWorkspace workspace;
  std::vector<TriangleContact> out(10);
  TrianglePair warm;
  for (const double bad : {nan, inf, -inf, 1e10, -1e300}) {
    Pose moved, turned;
    moved.p.y = bad;
    turned.R.zx = bad;
    for (const Pose& X : {moved, turned}) {
      EXPECT_EQ(find_distance(a, X, a, {}, warm, workspace).status, BubbleStatus::not_finite);
      EXPECT_EQ(find_distance(a, {}, a, X, warm, workspace).status, BubbleStatus::not_finite);
      EXPECT_EQ(find_pairs_within(a, {}, a, X, 1, out, workspace).status, BubbleStatus::not_finite);
    }
  }
  EXPECT_EQ(find_distance(a, {}, none, {}, warm, workspace).status, BubbleStatus::not_finite);
  EXPECT_EQ(find_distance(none, {}, a, {}, warm, workspace).status, BubbleStatus::not_finite);
  EXPECT_EQ(find_distance(a, {}, a, {}, warm, workspace, {.farthest = nan}).status, BubbleStatus::not_finite);
  EXPECT_EQ(find_pairs_within(a, {}, a, {}, nan, out, workspace).status, BubbleStatus::not_finite);
  EXPECT_EQ(find_pairs_within(a, {}, a, {}, -1, out, workspace).count, 0U);
  EXPECT_EQ(find_distance(a, {}, a, {}, warm, workspace, {.relative_error = nan}).distance, 0);
  EXPECT_EQ(find_distance(a, {}, a, {}, warm, workspace).status, BubbleStatus::touching);
  const BubbleDistance far = find_distance(a, {Mat3::identity(), {1e8, 0, 0}}, a, {Mat3::identity(), {-1e8, 0, 0}}, warm, workspace);
  EXPECT_NEAR(far.distance, 2e8 - 2, 1e-7);
}

// Thousands of coincident triangles: bounds cannot separate them, and the search still returns the correct distance.
TEST(Bubble, ManyCoincidentTrianglesAreSearched) {
  Mesh heap;
  for (int i = 0; i < 3000; ++i) {
    const auto first = static_cast<std::int32_t>(heap.vertices.size());
    heap.vertices.insert(heap.vertices.end(), {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
    heap.triangles.push_back({first, first + 1, first + 2});
  }
  const SphereTree a = tree_of(heap);
  BubbleWorkspace workspace;
  TrianglePair warm;
  EXPECT_NEAR(find_distance(a, {Mat3::identity(), {0, 0, 1}}, a, {}, warm, workspace).distance, 1, 1e-15);
  EXPECT_EQ(find_distance(a, {}, a, {}, warm, workspace).distance, 0);
}

}  // namespace
}  // namespace ugoki::collision
