// Convex hulls of ordinary, degenerate and hostile point sets.

#include "ugoki/geometry/make_hull.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <random>

#include "ugoki/spatial/rotation.h"

namespace ugoki::geometry {
namespace {

class Points {
 public:
  explicit Points(unsigned seed) : engine_(seed) {}
  double in(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  int below(int n) { return std::uniform_int_distribution<int>(0, n - 1)(engine_); }
  Vec3 unit() {
    for (;;) {
      const Vec3 v{in(-1, 1), in(-1, 1), in(-1, 1)};
      if (norm(v) > 0.1 && norm(v) < 1) return v / norm(v);
    }
  }

 private:
  std::mt19937_64 engine_;
};

/// Maximum signed distance [m] of a point from a face plane of the hull; positive outside.
double outside(const collision::Hull& h, const std::vector<Vec3>& points) {
  double worst = -1e300;
  for (const Vec3& p : points)
    for (int f = 0; f < h.faces(); ++f)
      worst = std::max(worst, dot(h.normals[static_cast<std::size_t>(f)], p) - h.offsets[static_cast<std::size_t>(f)]);
  return worst;
}

std::string refusal(const std::vector<Vec3>& points, const HullOptions& options = {}) {
  const Result<collision::Hull> h = make_hull(points, options);
  EXPECT_FALSE(h.has_value());
  if (h) return {};
  EXPECT_FALSE(h.error().problems.front().remedy.empty());
  return h.error().text();
}

TEST(MakeHull, ContainsAllPointsAndKeepsTheExtremeOnes) {
  Points random(1);
  for (int run = 0; run < 60; ++run) {
    const Vec3 size{std::pow(10, random.in(-4, 2)), std::pow(10, random.in(-4, 2)), std::pow(10, random.in(-4, 2))};
    const Mat3 R = rotation_about(random.unit(), random.in(-3, 3));
    const Vec3 offset = random.unit() * (run % 3 == 0 ? 1000.0 : 0.0);
    std::vector<Vec3> points;
    const int n = 4 + random.below(400);
    for (int i = 0; i < n; ++i) {
      const Vec3 u = random.unit() * (run % 2 == 0 ? 1.0 : random.in(0, 1));
      points.push_back(R * Vec3{u.x * size.x, u.y * size.y, u.z * size.z} + offset);
    }
    const Result<collision::Hull> h = make_hull(points);
    ASSERT_TRUE(h.has_value()) << h.error().text();
    ASSERT_EQ(h->dimension, 3);
    EXPECT_LE(outside(*h, points), 2e-13 * (h->radius + norm(offset)));
    if (run % 6 == 2) EXPECT_EQ(h->vertices.size(), points.size());
    EXPECT_EQ(h->hash, make_hull(points)->hash);
  }
}

TEST(MakeHull, CoplanarFacetsAreMerged) {
  std::vector<Vec3> points;
  for (int i = 0; i <= 10; ++i)
    for (int j = 0; j <= 10; ++j)
      for (int k = 0; k <= 10; ++k) points.push_back(rotation_about({0.6, 0, 0.8}, 1) * Vec3{i * 0.1, j * 0.1, k * 0.1});
  const Result<collision::Hull> h = make_hull(points);
  ASSERT_TRUE(h.has_value());
  EXPECT_EQ(h->faces(), 6);
  EXPECT_EQ(h->vertices.size(), 8u);
  EXPECT_NEAR(h->volume, 1, 1e-12);
  EXPECT_LE(outside(*h, points), 1e-14);
}

TEST(MakeHull, NearlyFlatFacetsAndCylinders) {
  Points random(2);
  std::vector<Vec3> points;  // points of a plate 2e-9 thick, later of a cylinder of 500 sides with rounding errors
  for (int i = 0; i < 2000; ++i) points.push_back({random.in(-1, 1), random.in(-1, 1), random.in(-1e-9, 1e-9)});
  const Result<collision::Hull> plate = make_hull(points);
  ASSERT_TRUE(plate.has_value()) << plate.error().text();
  EXPECT_EQ(plate->dimension, 3);
  EXPECT_LE(outside(*plate, points), 1e-12);
  points.clear();
  for (int i = 0; i < 500; ++i)
    for (const double z : {-1.0, 0.0, 1.0})
      points.push_back(rotation_about({0, 0.6, 0.8}, 2) * Vec3{std::cos(i * pi / 250), std::sin(i * pi / 250), z});
  const Result<collision::Hull> cylinder = make_hull(points);
  ASSERT_TRUE(cylinder.has_value()) << cylinder.error().text();
  EXPECT_LE(outside(*cylinder, points), 1e-13);
  EXPECT_EQ(cylinder->vertices.size(), 1000u);
  EXPECT_EQ(cylinder->faces(), 502);
}

TEST(MakeHull, CoplanarAndCollinearPointsGiveFlatHulls) {
  Points random(3);
  for (const double offset : {0.0, 1000.0}) {
    const Mat3 R = rotation_about(random.unit(), 1.1);
    std::vector<Vec3> disc, line;
    for (int i = 0; i < 500; ++i) {
      const Vec3 p{random.in(-1, 1), random.in(-1, 1), 0};
      if (norm(p) < 1) disc.push_back(R * p + Vec3{offset, -offset, offset});
      line.push_back(R * Vec3{random.in(-1, 1), 0, 0} + Vec3{offset, -offset, offset});
    }
    const Result<collision::Hull> flat = make_hull(disc), segment = make_hull(line);
    ASSERT_TRUE(flat.has_value()) << flat.error().text();
    ASSERT_TRUE(segment.has_value()) << segment.error().text();
    EXPECT_EQ(flat->dimension, 2);
    EXPECT_EQ(flat->faces(), 2);
    EXPECT_EQ(flat->volume, 0);
    EXPECT_LE(outside(*flat, disc), 1e-12 * (1 + offset));
    for (int v = 0; v < static_cast<int>(flat->vertices.size()); ++v) EXPECT_EQ(flat->neighbours_of(v).size(), 2u);
    EXPECT_EQ(segment->dimension, 1);
    EXPECT_EQ(segment->vertices.size(), 2u);
    EXPECT_EQ(segment->neighbours, (std::vector<std::int32_t>{1, 0}));
  }
  EXPECT_EQ(make_hull(std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 1, 0}})->vertices.size(), 3u);
}

TEST(MakeHull, UnusablePointsAreRefusedWithMessageAndRemedy) {
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  EXPECT_NE(refusal({{0, 0, 0}, {1, 0, 0}, {0, nan, 0}, {0, 0, 1}}).find("point 2"), std::string::npos);
  EXPECT_NE(refusal({{0, 0, 0}, {1, 0, 0}, {0, 0, 1}, {0, 0, -inf}}).find("finite"), std::string::npos);
  EXPECT_NE(refusal({{0, 0, 0}, {1e200, 0, 0}, {0, 0, 1}, {0, 1, 0}}).find("point 1"), std::string::npos);
  EXPECT_NE(refusal({}).find("0"), std::string::npos);
  EXPECT_NE(refusal({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}).find("at least 4"), std::string::npos);
  EXPECT_NE(refusal(std::vector<Vec3>(100, {3, 4, 5})).find("equal"), std::string::npos);
  Points random(4);
  std::vector<Vec3> sphere;
  for (int i = 0; i < 3000; ++i) sphere.push_back(random.unit());
  EXPECT_NE(refusal(sphere, {.max_vertices = 1000}).find("more than 1000 vertices"), std::string::npos);
}

TEST(MakeHull, HostileSetsGiveAHullOrAnError) {
  Points random(5);
  for (int run = 0; run < 3000; ++run) {
    std::vector<Vec3> points;
    const int n = random.below(40), kind = random.below(6);
    for (int i = 0; i < n; ++i) {
      Vec3 p{random.in(-1, 1), random.in(-1, 1), random.in(-1, 1)};
      if (kind == 1) p = {std::floor(p.x * 2), std::floor(p.y * 2), std::floor(p.z * 2)};  // a coarse grid
      if (kind == 2) p.z *= std::pow(10, -random.in(8, 18));                               // flat within rounding
      if (kind == 3) p = {p.x, p.x * 2 + random.in(-1, 1) * 1e-16, p.x * 3};               // a line within rounding
      if (kind == 4) p = Vec3{1e6, 1e6, 1e6} + p * std::pow(10, -random.in(0, 12));        // small and far away
      if (kind == 5) p = p * std::pow(10, random.in(-90, 90));                             // points of all magnitudes
      points.push_back(p);
    }
    const Result<collision::Hull> h = make_hull(points);
    if (h) {
      if (h->dimension == 3)
        EXPECT_LE(outside(*h, points), 1e-9 * h->radius + 1e-15 * norm(h->centre)) << "run " << run << " kind " << kind;
      EXPECT_TRUE(std::isfinite(h->radius) && is_finite(h->centre));
    } else {
      EXPECT_FALSE(h.error().text().empty());
    }
  }
}

/// Five million points: a solid cloud has a small hull; points on a sphere exceed the vertex limit and are refused.
TEST(Slow_MakeHull, MillionsOfPoints) {
  Points random(6);
  std::vector<Vec3> cloud, sphere;
  for (int i = 0; i < 5'000'000; ++i) {
    const Vec3 u = random.unit();
    sphere.push_back(u);
    cloud.push_back(u * std::sqrt(random.in(0, 1)));
  }
  const auto start = std::chrono::steady_clock::now();
  const Result<collision::Hull> h = make_hull(cloud);
  EXPECT_TRUE(h.has_value());
  const auto middle = std::chrono::steady_clock::now();
  const std::string text = refusal(sphere);
  EXPECT_NE(text.find("more than"), std::string::npos);
  const auto seconds = [](auto t) { return std::chrono::duration<double>(t).count(); };
  std::printf("  cloud %.1f s (%zu vertices), sphere refused after %.1f s\n", seconds(middle - start), h ? h->vertices.size() : 0,
              seconds(std::chrono::steady_clock::now() - middle));
}

}  // namespace
}  // namespace ugoki::geometry
