// Warm-started search of two hulls: distances certified in motions of all sizes, at all distances, for regular and degenerate hulls.

#include "../allocations/allocation_count.h"
#include "convex_oracles.h"
#include "ugoki/collision/gilbert_width.h"
#include "ugoki/collision/hull_leap.h"

namespace ugoki::collision {
namespace {

constexpr double allowed = 1e-9;  // error relative to the sum of the sizes of both hulls

/// Hulls of 2 ... 3000 vertices, scaled by `scale`: round hulls, plates of thickness 1e-4, needles, boxes, flat hulls, a fan, a segment.
std::vector<Hull> all_kinds(test::Random& random, double scale) {
  std::vector<std::vector<Vec3>> sets;
  for (const int n : {4, 6, 12, 17, 40, 400, 3000}) sets.push_back(test::on_ellipsoid(random, n, {0.5, 0.4, 0.3}));
  for (const Vec3& axes : {Vec3{0.5, 0.5, 1e-4}, Vec3{0.5, 1e-4, 1e-4}, Vec3{0.5, 0.4, 0}}) {
    sets.push_back(test::on_ellipsoid(random, 30, axes));
    sets.push_back(test::on_ellipsoid(random, 200, axes));
  }
  for (const Vec3& h : {Vec3{0.5, 0.4, 0.3}, Vec3{0.5, 0.5, 5e-5}, Vec3{0.5, 5e-5, 5e-5}, Vec3{0.5, 5e-4, 5e-6}}) {
    std::vector<Vec3> box;
    for (int k = 0; k < 8; ++k) box.push_back({k & 1 ? h.x : -h.x, k & 2 ? h.y : -h.y, k & 4 ? h.z : -h.z});
    sets.push_back(box);
  }
  std::vector<Vec3> fan;  // a vertex with 40 neighbours
  for (int k = 0; k < 40; ++k) fan.push_back({0.5 * std::cos(k * pi / 20), 0.5 * std::sin(k * pi / 20), 0});
  fan.push_back({0.05, 0, 0.2});
  sets.push_back(fan);
  sets.push_back({{0, 0, -0.5}, {0, 0, 0.1}, {0, 0, 0.5}, {0, 0, 0.2}});
  std::vector<Hull> out;
  for (std::vector<Vec3>& points : sets) {
    for (Vec3& p : points) p = p * scale;
    out.push_back(test::hull_of(points));
  }
  return out;
}

/// Distance of p from the point, segment or triangle with these corners.
double distance_from(const Vec3& p, const std::vector<Vec3>& corners) {
  double minimum = norm(p - corners[0]);
  for (std::size_t i = 0; i < corners.size(); ++i)
    for (std::size_t k = 0; k < i; ++k) {
      const Vec3 e = corners[i] - corners[k];
      const double t = dot(e, e) > 0 ? std::clamp(dot(p - corners[k], e) / dot(e, e), 0.0, 1.0) : 0;
      minimum = std::min(minimum, norm(p - corners[k] - e * t));
    }
  if (corners.size() < 3) return minimum;
  const Vec3 e = corners[1] - corners[0], f = corners[2] - corners[0], q = p - corners[0], n = cross(e, f);
  const double s = dot(cross(q, f), n), t = dot(cross(e, q), n), nn = dot(n, n);
  return nn > 0 && s >= 0 && t >= 0 && s + t <= nn ? std::min(minimum, std::fabs(dot(q, n)) / std::sqrt(nn)) : minimum;
}

/// Maximum distance [m] of the closest points from the features (vertices, edges or triangles) that the cache contains.
double off_features(const GilbertCache& cache, const Support& a, const Pose& A, const Support& b, const Pose& B, const GilbertResult& r) {
  std::vector<Vec3> on_a, on_b;
  for (int k = 0; k < cache.count; ++k) {
    on_a.push_back(A * a.hull->vertices[static_cast<std::size_t>(cache.a[static_cast<std::size_t>(k)])]);
    on_b.push_back(B * b.hull->vertices[static_cast<std::size_t>(cache.b[static_cast<std::size_t>(k)])]);
  }
  return std::max(distance_from(r.pa + r.n * a.radius, on_a), distance_from(r.pb - r.n * b.radius, on_b));
}

/// A random cache: empty; marked as fast motion; or with an arbitrary or invalid predicted motion (trend).
GilbertCache any_cache(test::Random& random) {
  GilbertCache cache;
  const int kind = random.below(4);
  if (kind == 0) return cache;
  cache.trend.pace = 1 << 20;
  if (kind == 1) return cache;
  const Vec3 n = random.unit(), change = random.vec(0.1);
  cache.trend.next = {n.x, n.y, n.z, 0};
  cache.trend.change = {change.x, change.y, change.z, 0};
  cache.trend.inverse_distance = random.in(-1, 1);
  if (kind == 2) cache.trend.next[1] = std::numeric_limits<double>::quiet_NaN();
  return cache;
}

/// Statistics over all queries.
struct Tally {
  int separated = 0, quick = 0, maximum = 0;  // separated results; results after at most 2 iterations; maximum number of iterations
  double worst = 0, off = 0;                  // maximum relative error, and maximum relative distance from the cached features
};

/// Moves one pair in steps of 1e-6 to 0.3 (times the size, and in rad), or 0. Every result must be certified.
void certify_motion(test::Random& random, const Support& a, const Support& b, double scale, Tally& tally) {
  const double gaps[] = {1, 0.3, 0.1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 0};
  const double gap = gaps[random.below(9)] * scale, offset = random.below(4) == 0 ? 1000 * scale : 0;
  Pose A = random.pose(0.3 * scale), B = random.pose(0.3 * scale);
  if (random.below(2) == 0) B.R = A.R;  // makes faces and edges of equal shapes parallel
  A.p += random.unit() * offset;
  const Vec3 n = random.below(3) == 0 ? A.R.column(random.below(3)) : random.unit();
  B.p = A.p + random.vec(0.1 * scale);
  B.p += n * (test::reach(a, A, n) + test::reach(b, B, -n) + a.radius + b.radius + gap);
  const double stride = std::pow(10.0, random.in(-6, -0.5));
  const Vec3 turn = random.unit(), drift = random.unit() * (stride * scale * random.in(0, 1));
  GilbertCache cache = any_cache(random);
  for (int step = 0; step < 8; ++step) {
    const GilbertResult r = gilbert_distance(a, A, b, B, cache);
    ASSERT_TRUE(r.status == GilbertStatus::separated || r.status == GilbertStatus::touching) << int(r.status);
    ASSERT_TRUE(is_finite(r.pa) && is_finite(r.pb) && is_finite(r.n) && r.distance - r.distance == 0);
    tally.maximum = std::max(tally.maximum, r.iterations);
    if (r.status == GilbertStatus::separated) {
      ++tally.separated;
      tally.quick += step > 0 && r.iterations <= 2 ? 1 : 0;
      const double size = test::size_of(a) + test::size_of(b) + 1e-6 * norm(A.p);
      const double error =
          std::max(test::certificate(a, A, b, B, r.distance, r.pa, r.pb, r.n), r.distance - r.lower) / std::max(size, 1e-300);
      tally.worst = std::max(tally.worst, error);
      const double off = off_features(cache, a, A, b, B, r) / std::max(size, 1e-300);
      tally.off = std::max(tally.off, off);
      ASSERT_LE(off, allowed) << "gap " << gap << " scale " << scale << " offset " << offset << " step " << step;
      ASSERT_LE(error, allowed) << "gap " << gap << " scale " << scale << " offset " << offset << " step " << step;
    }
    if (random.below(4) == 0) continue;
    B.R = rotation_about(turn, stride) * B.R;
    B.p += drift;
  }
}

void certify_motions(int motions, unsigned seed) {
  test::Random random(seed);
  Tally tally;
  for (const double scale : {1.0, 1e-3, 1e3}) {
    const std::vector<Hull> hulls = all_kinds(random, scale);
    const auto any = [&] {
      const Hull& h = hulls[static_cast<std::size_t>(random.below(static_cast<int>(hulls.size())))];
      return Support::of(h, random.below(4) == 0 ? 0.02 * scale : 0);
    };
    for (int i = 0; i < motions; ++i) {
      const Support a = any(), b = any();
      certify_motion(random, a, b, scale, tally);
      if (::testing::Test::HasFatalFailure())
        FAIL() << "seed " << seed << ", motion " << i << ", vertices " << a.hull->vertices.size() << " " << b.hull->vertices.size();
    }
  }
  EXPECT_GT(tally.separated, motions * 12);
  EXPECT_LT(tally.maximum, 100);
  std::printf(
      "  %d poses apart (seed %u), %d of them with at most 2 support points; worst error %.2g of the size, at most %d support points; "
      "closest points at most %.2g of the size off the cached features\n",
      tally.separated, seed, tally.quick, tally.worst, tally.maximum, tally.off);
}

TEST(HullSearch, MotionsAreCertified) { certify_motions(1500, 301); }
TEST(Slow_HullSearch, MotionsAreCertifiedInALongRun) { certify_motions(50'000, 302); }

/// If the hulls move little between queries, HullSearch finds the closest points in at least 99 % of the queries, so that the general
/// search is not needed.
TEST(HullSearch, HandlesSlowMotionWithoutGeneralSearch) {
  test::Random random(31);
  for (const int n : {4, 16, 64, 1000, 8000}) {
    const Hull ha = test::hull_of(test::on_ellipsoid(random, n, {0.5, 0.4, 0.3})),
               hb = test::hull_of(test::on_ellipsoid(random, n, {0.5, 0.4, 0.3}));
    const Support a = Support::of(ha), b = Support::of(hb, 0.01);
    Mat3 R = Mat3::identity();
    GilbertCache cache;
    int found = 0;
    for (int i = 0; i < 1000; ++i) {
      R = rotation_about({0.6, 0, 0.8}, pi / 180) * R;
      const double t = i * 0.01;
      const Pose A{R, {}}, B{R.transposed(), {1.3 * std::cos(t), 1.3 * std::sin(t), 0.2 * std::sin(3 * t)}};
      GilbertCache tried = cache;
      GilbertResult found_by_search;
      if (HullSearch(a, A, b, B, tried, {}).run(found_by_search)) ++found;
      const GilbertResult r = gilbert_distance(a, A, b, B, cache);
      ASSERT_EQ(r.status, GilbertStatus::separated);
    }
    EXPECT_GE(found, 990) << n << " vertices";
  }
}

/// In fast motion the closest vertices change at nearly every query. HullLeap finds the closest points in at least 90 % of the queries.
TEST(HullLeap, HandlesFastMotionOfLargeHulls) {
  test::Random random(33);
  for (const int n : {1000, 4000, 16000}) {
    const Hull ha = test::hull_of(test::on_ellipsoid(random, n, {0.5, 0.4, 0.3})),
               hb = test::hull_of(test::on_ellipsoid(random, n, {0.3, 0.5, 0.4}));
    const Support a = Support::of(ha), b = Support::of(hb, 0.01);
    Mat3 R = Mat3::identity();
    GilbertCache cache;
    int leaps = 0, support_points = 0;
    long allocated = 0;
    for (int i = 0; i < 1000; ++i) {
      R = rotation_about({0.6, 0, 0.8}, 1.5 * pi / 180) * R;
      const double t = i * 0.015;
      const Pose A{R, {0.1 * std::sin(t), 0, 0}}, B{R.transposed(), {1.3 * std::cos(t), 1.3 * std::sin(t), 0.2 * std::sin(3 * t)}};
      GilbertCache tried = cache, cold;
      GilbertResult leapt;
      if (cache.trend.pace > fast_pace && HullLeap(a, A, b, B, tried, {}).run(leapt)) ++leaps;
      const long before = allocations_so_far();
      const GilbertResult r = gilbert_distance(a, A, b, B, cache);
      allocated += allocations_so_far() - before;
      const GilbertResult rebuilt = gilbert_distance(a, A, b, B, cold);
      ASSERT_EQ(r.status, GilbertStatus::separated);
      ASSERT_NEAR(r.distance, rebuilt.distance, 1e-12);
      ASSERT_LE(test::certificate(a, A, b, B, r.distance, r.pa, r.pb, r.n), 1e-12);
      support_points += r.iterations;
    }
    EXPECT_GE(leaps, 900) << n << " vertices";
    EXPECT_LE(support_points, 3300) << n << " vertices";
    EXPECT_EQ(allocated, 0);
  }
}

bool same(const GilbertResult& r, const GilbertResult& s) {
  return r.status == s.status && r.iterations == s.iterations && r.distance == s.distance && r.lower == s.lower && r.pa == s.pa &&
         r.pb == s.pb && r.n == s.n;
}

/// Compares every SIMD variant that this machine can run with the portable variant.
TEST(HullSearch, SameBitsForEveryRegisterWidth) {
  test::Random random(32);
  const std::vector<Hull> hulls = all_kinds(random, 1);
  for (int i = 0; i < 6000; ++i) {
    const auto any = [&] {
      return Support::of(hulls[static_cast<std::size_t>(random.below(static_cast<int>(hulls.size())))], i % 3 == 0 ? 0.01 : 0);
    };
    const Support a = any(), b = any();
    Pose A = random.pose(0.3), B = random.pose(1.2);
    GilbertCache library = any_cache(random), plain = library, wide = library, wider = library;
    for (int k = 0; k < 5; ++k) {
      const GilbertResult r = gilbert_distance(a, A, b, B, library);
      ASSERT_TRUE(same(r, hull_distance(a, A, b, B, plain, {}))) << i;
#ifdef __x86_64__
      if (__builtin_cpu_supports("avx2")) {
        ASSERT_TRUE(same(r, hull_distance_avx2(a, A, b, B, wide, {}))) << i;
      }
      if (__builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq")) {
        ASSERT_TRUE(same(r, hull_distance_avx512(a, A, b, B, wider, {}))) << i;
      }
#endif
      A.p.x += 0.01;
      B.R = rotation_about({0, 0.6, 0.8}, 0.02) * B.R;
    }
  }
}

}  // namespace
}  // namespace ugoki::collision
