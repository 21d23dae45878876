// The search of two hulls from what the last query left: certified in motions of every size, at every distance, on degenerate hulls.

#include "ugoki/collision/hull_search.h"
#include "convex_oracles.h"
#include "ugoki/collision/gilbert_width.h"

namespace ugoki::collision {
namespace {

constexpr double allowed = 1e-9;  // of the sizes

/// Hulls of 2 ... 3000 vertices, plates 1e-4 thick, needles, boxes, a wedge, flat ones, a segment; times `scale`.
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

struct Tally {
  int separated = 0, quick = 0, most = 0;
  double worst = 0;
};

/// One pair, moved in steps from 1e-6 to 0.3 (of the size, and radians) and sometimes not at all. Every answer proved.
void certify_motion(test::Random& random, const Support& a, const Support& b, double scale, Tally& tally) {
  const double gaps[] = {1, 0.3, 0.1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 0};
  const double gap = gaps[random.below(9)] * scale, offset = random.below(4) == 0 ? 1000 * scale : 0;
  Pose A = random.pose(0.3 * scale), B = random.pose(0.3 * scale);
  if (random.below(2) == 0) B.R = A.R;  // parallel faces and edges, where the shapes have them
  A.p += random.unit() * offset;
  const Vec3 n = random.below(3) == 0 ? A.R.column(random.below(3)) : random.unit();
  B.p = A.p + random.vec(0.1 * scale);
  B.p += n * (test::reach(a, A, n) + test::reach(b, B, -n) + a.radius + b.radius + gap);
  const double stride = std::pow(10.0, random.in(-6, -0.5));
  const Vec3 turn = random.unit(), way = random.unit() * (stride * scale * random.in(0, 1));
  GilbertCache cache;
  for (int step = 0; step < 8; ++step) {
    const GilbertResult r = gilbert_distance(a, A, b, B, cache);
    ASSERT_TRUE(r.status == GilbertStatus::separated || r.status == GilbertStatus::touching) << int(r.status);
    ASSERT_TRUE(is_finite(r.pa) && is_finite(r.pb) && is_finite(r.n) && r.distance - r.distance == 0);
    tally.most = std::max(tally.most, r.iterations);
    if (r.status == GilbertStatus::separated) {
      ++tally.separated;
      tally.quick += step > 0 && r.iterations <= 2 ? 1 : 0;
      const double size = test::size_of(a) + test::size_of(b) + 1e-6 * norm(A.p);
      const double error =
          std::max(test::certificate(a, A, b, B, r.distance, r.pa, r.pb, r.n), r.distance - r.lower) / std::max(size, 1e-300);
      // The certificate's |n| - 1 is no length.
      tally.worst = std::max(tally.worst, error);
      ASSERT_LE(error, allowed) << "gap " << gap << " scale " << scale << " offset " << offset << " step " << step;
    }
    if (random.below(4) == 0) continue;
    B.R = rotation_about(turn, stride) * B.R;
    B.p += way;
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
  EXPECT_LT(tally.most, 100);
  std::printf("  %d poses apart (seed %u), %d of them after at most 2 rings; worst error %.2g of the size, at most %d support points\n",
              tally.separated, seed, tally.quick, tally.worst, tally.most);
}

TEST(HullSearch, MotionsCertified) { certify_motions(1500, 301); }
TEST(Slow_HullSearch, AMillionPosesInMotionCertified) { certify_motions(50'000, 302); }

/// In slow motion the rings do it, not the general search.
TEST(HullSearch, TakesOverInSlowMotion) {
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
      GilbertResult rings;
      if (HullSearch(a, A, b, B, tried, {}).run(rings)) ++found;
      const GilbertResult r = gilbert_distance(a, A, b, B, cache);
      ASSERT_EQ(r.status, GilbertStatus::separated);
    }
    EXPECT_GE(found, 990) << n << " vertices";
  }
}

bool same(const GilbertResult& r, const GilbertResult& s) {
  return r.status == s.status && r.iterations == s.iterations && r.distance == s.distance && r.lower == s.lower && r.pa == s.pa &&
         r.pb == s.pb && r.n == s.n;
}

/// Every search that this machine can run, and the one that every machine runs.
TEST(HullSearch, SameBitsInEveryWidthOfRegisters) {
  test::Random random(32);
  const std::vector<Hull> hulls = all_kinds(random, 1);
  for (int i = 0; i < 6000; ++i) {
    const auto any = [&] {
      return Support::of(hulls[static_cast<std::size_t>(random.below(static_cast<int>(hulls.size())))], i % 3 == 0 ? 0.01 : 0);
    };
    const Support a = any(), b = any();
    Pose A = random.pose(0.3), B = random.pose(1.2);
    GilbertCache library, plain, wide, wider;
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
