// Gilbert distances: certified by the duality gap, and compared with brute force over all features and with closed forms.
// fcl_convex_test.cpp compares the distances with FCL.

#include <limits>

#include "../allocations/allocation_count.h"
#include "convex_oracles.h"
#include "ugoki/base/hash.h"
#include "ugoki/collision/gilbert.h"
#include "ugoki/collision/round.h"

namespace ugoki::collision {
namespace {

constexpr double allowed = 1e-9;  // error relative to the sum of the sizes of both shapes

/// Random pairs at distances of up to 2.5 m, a tenth of them far from the origin: every distance must be certified.
void certify_random_pairs(int pairs, unsigned seed) {
  test::Random random(seed);
  const std::vector<Hull> hulls = test::some_hulls(random);
  int separated = 0, maximum = 0;
  double worst = 0;
  for (int i = 0; i < pairs; ++i) {
    const Support a = test::random_support(random, hulls), b = test::random_support(random, hulls);
    Pose A = random.pose(0.3), B = random.pose(0.3);
    B.p += random.unit() * random.in(0, 2.5);
    if (i % 10 == 0) {  // every tenth pair is far from the origin
      const Vec3 far = random.vec(1000);
      A.p += far;
      B.p += far;
    }
    GilbertCache cache;
    const GilbertResult r = gilbert_distance(a, A, b, B, cache);
    ASSERT_NE(r.status, GilbertStatus::not_finite);
    ASSERT_NE(r.status, GilbertStatus::not_converged) << "seed " << seed << ", pair " << i;
    maximum = std::max(maximum, r.iterations);
    if (r.status != GilbertStatus::separated) continue;
    ++separated;
    const double size = test::size_of(a) + test::size_of(b) + (i % 10 == 0 ? 1e-3 : 0);
    const double error = std::max(test::certificate(a, A, b, B, r.distance, r.pa, r.pb, r.n), r.distance - r.lower) / size;
    worst = std::max(worst, error);
    ASSERT_LE(error, allowed) << "seed " << seed << ", pair " << i << ", kinds " << int(a.kind) << " " << int(b.kind);
  }
  EXPECT_GT(separated, pairs / 2);
  EXPECT_LT(maximum, 100);
  std::printf("  %d pairs apart (seed %u), worst error %.2g of the size, at most %d support points\n", separated, seed, worst, maximum);
}

TEST(Gilbert, RandomPairsAreCertified) { certify_random_pairs(20000, 101); }
TEST(Slow_Gilbert, RandomPairsAreCertifiedInALongRun) { certify_random_pairs(1'500'000, 102); }

/// The same box as a box support and as a hull support.
struct TwoBoxes {
  Hull hull;
  Support box, as_hull;
  explicit TwoBoxes(const Vec3& h)
      : hull(test::hull_of({{h.x, h.y, h.z},
                            {h.x, h.y, -h.z},
                            {h.x, -h.y, h.z},
                            {h.x, -h.y, -h.z},
                            {-h.x, h.y, h.z},
                            {-h.x, h.y, -h.z},
                            {-h.x, -h.y, h.z},
                            {-h.x, -h.y, -h.z}})),
        box(Support::box(h)),
        as_hull(Support::of(hull)) {}
};

TEST(Gilbert, ParallelFacesAndEdgesAtAllGapsOffsetsAndScales) {
  test::Random random(11);
  const Mat3 edge_up = rotation_about({0, 1, 0}, pi / 4);  // an edge along y becomes the lowest feature
  for (const double scale : {1e-3, 1.0, 1e3}) {
    std::vector<Vec3> shapes{{0.5, 0.4, 0.3}, {0.5, 0.5, 5e-5}, {5e-5, 5e-5, 0.5}, {5e-5, 0.5, 0.5}, {0.5, 5e-4, 5e-6}};
    for (const Vec3& ha : shapes)
      for (const Vec3& hb : shapes) {
        const TwoBoxes one(ha * scale), two(hb * scale);
        for (const double gap : {1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 0.0})
          for (const double offset : {0.0, 1000.0})
            for (const bool edge : {false, true}) {
              const double reach = edge ? (ha.x + ha.z) * std::sqrt(0.5) : ha.z, shift = edge ? (ha.x - ha.z) * std::sqrt(0.5) : 0;
              const Pose frame{rotation_about(random.unit(), random.in(-pi, pi)), random.unit() * offset};
              Pose B = frame, A = frame * Pose{edge ? edge_up : Mat3::identity(), {(random.in(-0.1, 0.1) * hb.x - shift) * scale, 0, 0}};
              A.p += frame.R * Vec3{0, 0, (reach + hb.z + gap) * scale};
              for (const Support& a : {one.box, one.as_hull})
                for (const Support& b : {two.box, two.as_hull}) {
                  GilbertCache cache;
                  for (int repeat = 0; repeat < 2; ++repeat) {
                    const GilbertResult r = gilbert_distance(a, A, b, B, cache);
                    ASSERT_NE(r.status, GilbertStatus::not_converged);
                    ASSERT_NE(r.status, GilbertStatus::not_finite);
                    ASSERT_LE(r.iterations, 50);
                    ASSERT_NEAR(r.distance, gap * scale, 1e-9 * scale) << "gap " << gap << " scale " << scale << " offset " << offset;
                    ASSERT_TRUE(is_finite(r.pa) && is_finite(r.pb) && is_finite(r.n));
                    if (gap > 0) ASSERT_EQ(r.status, GilbertStatus::separated);
                    if (gap > 0) ASSERT_LE(test::certificate(a, A, b, B, r.distance, r.pa, r.pb, r.n), 1e-9 * scale);
                  }
                }
            }
      }
  }
}

TEST(Gilbert, CoincidentShapesTouch) {
  test::Random random(12);
  const std::vector<Hull> hulls = test::some_hulls(random);
  for (int i = 0; i < 2000; ++i) {
    const Support a = test::random_support(random, hulls);
    const Pose A = random.pose(i % 2 == 0 ? 0 : 1000);
    GilbertCache cache;
    const GilbertResult r = gilbert_distance(a, A, a, A, cache);
    EXPECT_EQ(r.status, GilbertStatus::touching) << int(a.kind);
    EXPECT_TRUE(is_finite(r.pa) && is_finite(r.pb));
    EXPECT_LT(r.iterations, 60);
  }
}

/// Distance of p from the triangle a, b, c: minimum of the distances from its plane, edges and corners.
double point_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 n = cross(b - a, c - a);
  double best = 1e300;
  const double s = dot(cross(b - a, p - a), n), t = dot(cross(c - b, p - b), n), u = dot(cross(a - c, p - c), n);
  if (s >= 0 && t >= 0 && u >= 0) best = std::fabs(dot(p - a, n)) / norm(n);
  const Vec3 corner[3] = {a, b, c};
  for (int k = 0; k < 3; ++k) {
    const Vec3 e = corner[(k + 1) % 3] - corner[k];
    const double w = std::clamp(dot(p - corner[k], e) / dot(e, e), 0.0, 1.0);
    best = std::min(best, norm(p - corner[k] - e * w));
  }
  return best;
}

double point_hull(const Vec3& p, const Hull& h, const Pose& X) {
  double best = 1e300;
  for (int f = 0; f < h.faces(); ++f) {
    const auto ring = h.face(f);
    const auto at = [&](std::size_t k) { return X * h.vertices[static_cast<std::size_t>(ring[k])]; };
    for (std::size_t k = 1; k + 1 < ring.size(); ++k) best = std::min(best, point_triangle(p, at(0), at(k), at(k + 1)));
  }
  return best;
}

/// Minimum distance over all pairs of a vertex and a face, and of two edges.
double brute_force(const Hull& a, const Pose& A, const Hull& b, const Pose& B) {
  double best = 1e300;
  for (const Vec3& v : a.vertices) best = std::min(best, point_hull(A * v, b, B));
  for (const Vec3& v : b.vertices) best = std::min(best, point_hull(B * v, a, A));
  const auto edge = [](const Hull& h, const Pose& X, int i, int k) {
    const Vec3 p = X * h.vertices[static_cast<std::size_t>(i)], q = X * h.vertices[static_cast<std::size_t>(k)];
    return Round{(p + q) * 0.5, normalized(q - p), 0.5 * norm(q - p), 0};
  };
  for (int i = 0; i < static_cast<int>(a.vertices.size()); ++i)
    for (const std::int32_t k : a.neighbours_of(i))
      for (int m = 0; m < static_cast<int>(b.vertices.size()); ++m)
        for (const std::int32_t o : b.neighbours_of(m))
          if (k > i && o > m) {
            const Round u = edge(a, A, i, k), v = edge(b, B, m, o);
            const SegmentPair s = nearest_on_segments(u, v);
            best = std::min(best, norm(u.at(s.s) - v.at(s.t)));
          }
  return best;
}

TEST(Gilbert, MatchesBruteForceOverFeatures) {
  test::Random random(13);
  int compared = 0;
  for (int i = 0; i < 800; ++i) {
    const Hull a = test::hull_of(test::on_ellipsoid(random, 4 + random.below(12), {0.5, random.in(0.05, 0.5), random.in(0.001, 0.5)}));
    const Hull b = test::hull_of(test::on_ellipsoid(random, 4 + random.below(12), {0.5, random.in(0.05, 0.5), random.in(0.001, 0.5)}));
    const Pose A = random.pose(0.3);
    Pose B = random.pose(0.3);
    B.p += random.unit() * random.in(0.3, 1.2);
    GilbertCache cache;
    const GilbertResult r = gilbert_distance(Support::of(a), A, Support::of(b), B, cache);
    if (r.status != GilbertStatus::separated) continue;
    ++compared;
    EXPECT_NEAR(r.distance, brute_force(a, A, b, B), 1e-12) << i;
  }
  EXPECT_GT(compared, 400);
}

/// Coherent motion of two hulls: warm and cold starts agree, and the warm search needs fewer than 4 support points on average.
TEST(Gilbert, WarmStartMatchesColdStartAndIsFast) {
  test::Random random(14);
  for (const int n : {12, 200, 4000}) {
    const Hull a = test::hull_of(test::on_ellipsoid(random, n, {0.5, 0.4, 0.3})),
               b = test::hull_of(test::on_ellipsoid(random, n, {0.4, 0.4, 0.2}));
    GilbertCache warm;
    long steps = 0;
    Mat3 R = Mat3::identity();
    for (int i = 0; i < 1500; ++i) {
      R = rotation_about({0.6, 0, 0.8}, pi / 180) * R;
      const double t = i * 0.01;
      const Pose A{R, {0, 0, 0}}, B{R.transposed(), {1.3 * std::cos(t), 1.3 * std::sin(t), 0.2 * std::sin(3 * t)}};
      const GilbertResult w = gilbert_distance(Support::of(a), A, Support::of(b), B, warm);
      GilbertCache cold;
      const GilbertResult c = gilbert_distance(Support::of(a), A, Support::of(b), B, cold);
      ASSERT_EQ(w.status, GilbertStatus::separated);
      ASSERT_NEAR(w.distance, c.distance, 1e-13);
      steps += w.iterations;
    }
    EXPECT_LT(static_cast<double>(steps) / 1500, 4) << n << " vertices";
  }
}

TEST(Gilbert, ForeignCacheDoesNotChangeTheResult) {
  test::Random random(15);
  const std::vector<Hull> hulls = test::some_hulls(random);
  for (int i = 0; i < 3000; ++i) {
    const Support a = test::random_support(random, hulls), b = test::random_support(random, hulls);
    Pose A = random.pose(0.3), B = random.pose(0.3);
    B.p += random.unit() * 2.0;
    GilbertCache clean, foreign;
    foreign.count = random.below(6) - 1;
    for (std::size_t k = 0; k < 3; ++k) {
      foreign.a[k] = random.below(4) == 0 ? -5 : random.below(3) == 0 ? 1 << 30 : random.below(30);
      foreign.b[k] = random.below(4) == 0 ? 2000000000 : random.below(30);
    }
    foreign.n = i % 3 == 0 ? Vec3{std::nan(""), 0, 0} : random.unit();
    const GilbertResult r = gilbert_distance(a, A, b, B, clean), s = gilbert_distance(a, A, b, B, foreign);
    ASSERT_EQ(r.status, s.status) << i;
    ASSERT_NEAR(r.distance, s.distance, 4e-10);
  }
}

TEST(Gilbert, HalfSpaceMatchesClosedForm) {
  test::Random random(16);
  const std::vector<Hull> hulls = test::some_hulls(random);
  for (int i = 0; i < 3000; ++i) {
    const Support a = test::random_support(random, hulls), plane = Support::half_space(i % 2 == 0 ? 0 : 0.1);
    const Pose A = random.pose(1), P = random.pose(1);
    GilbertCache cache;
    const GilbertResult r = gilbert_distance(a, A, plane, P, cache), s = gilbert_distance(plane, P, a, A, cache);
    const Vec3 up = P.R.column(2);
    const double height = -test::reach(a, A, -up) - dot(up, P.p) - a.radius - plane.radius;
    EXPECT_NEAR(r.distance, height, 1e-14 * 10);
    EXPECT_NEAR(r.distance, s.distance, 1e-14);
    EXPECT_NEAR(norm(r.n - up) + norm(s.n + up) + norm(r.pa - r.pb - r.n * r.distance), 0, 1e-13);
  }
  GilbertCache cache;
  EXPECT_EQ(gilbert_distance(Support::half_space(), {}, Support::half_space(), {}, cache).status, GilbertStatus::not_bounded);
}

TEST(Gilbert, NonFiniteInputIsReported) {
  test::Random random(17);
  const std::vector<Hull> hulls = test::some_hulls(random);
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()})
    for (int location = 0; location < 24; ++location) {
      const Support a = test::random_support(random, hulls), b = test::random_support(random, hulls);
      Pose X[2] = {random.pose(1), random.pose(1)};
      Pose& x = X[location / 12];
      double* const entry[12] = {&x.R.xx, &x.R.xy, &x.R.xz, &x.R.yx, &x.R.yy, &x.R.yz, &x.R.zx, &x.R.zy, &x.R.zz, &x.p.x, &x.p.y, &x.p.z};
      *entry[location % 12] = bad;
      GilbertCache cache;
      EXPECT_EQ(gilbert_distance(a, X[0], b, X[1], cache).status, GilbertStatus::not_finite);
    }
  GilbertCache cache;
  EXPECT_EQ(gilbert_distance(Support::box({1, std::nan(""), 1}), {}, Support::sphere(1), {{}, {5, 0, 0}}, cache).status,
            GilbertStatus::not_finite);
  const Hull empty;
  EXPECT_EQ(gilbert_distance(Support::of(empty), {}, Support::sphere(1), {}, cache).status, GilbertStatus::not_finite);
}

TEST(Gilbert, StopsBeyondTheFarthestDistance) {
  test::Random random(18);
  const std::vector<Hull> hulls = test::some_hulls(random);
  int stopped = 0;
  for (int i = 0; i < 5000; ++i) {
    const Support a = test::random_support(random, hulls), b = test::random_support(random, hulls);
    Pose A = random.pose(0.3), B = random.pose(0.3);
    B.p += random.unit() * 2.0;
    GilbertCache one, two;
    GilbertOptions options;
    options.farthest = random.in(-0.2, 1.5);
    const GilbertResult full = gilbert_distance(a, A, b, B, one), part = gilbert_distance(a, A, b, B, two, options);
    if (part.status == GilbertStatus::beyond) {
      ++stopped;
      ASSERT_GT(part.lower, options.farthest);
      ASSERT_LE(part.lower, full.distance + 1e-12);
    } else {
      ASSERT_LE(full.lower, options.farthest + 1e-9);
      ASSERT_NEAR(part.distance, full.distance, 1e-9);
    }
  }
  EXPECT_GT(stopped, 1000);
}

TEST(Gilbert, SameBitsAndNoAllocation) {
  std::uint64_t bits[2];
  for (std::uint64_t& out : bits) {
    test::Random random(19);
    const std::vector<Hull> hulls = test::some_hulls(random);
    Hash64 hash;
    const long before = allocations_so_far();
    for (int i = 0; i < 3000; ++i) {
      const Support a = test::random_support(random, hulls), b = test::random_support(random, hulls);
      Pose A = random.pose(0.3), B = random.pose(1.5);
      GilbertCache cache;
      for (int k = 0; k < 3; ++k) {
        const GilbertResult r = gilbert_distance(a, A, b, B, cache);
        for (const double x : {r.distance, r.lower, r.pa.x, r.pa.y, r.pa.z, r.pb.x, r.n.x, r.n.y, r.n.z}) hash.add(x);
        A.p.x += 0.01;
      }
    }
    EXPECT_EQ(allocations_so_far(), before);
    out = hash.value();
  }
  EXPECT_EQ(bits[0], bits[1]);
}

}  // namespace
}  // namespace ugoki::collision
