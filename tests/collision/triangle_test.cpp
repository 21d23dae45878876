// Distance between two triangles, certified by the closest points: they are on the triangles (so the distance is not too small), and the
// slab between them separates the triangles (so the distance is not too large).

#include "ugoki/collision/triangle_distance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "random_shapes.h"

namespace ugoki::collision {
namespace {

using test::Random;

double size_of(const TriangleCorners& a, const TriangleCorners& b) {
  double size = 0;
  for (const Vec3& v : a) size = std::max({size, norm(v - a[0]), norm(v - b[0])});
  for (const Vec3& v : b) size = std::max({size, norm(v - a[0]), norm(v - b[0])});
  return size;
}

using Long = Vec3T<long double>;  // 64-bit mantissa, for the normals of needles
Long to_long(const Vec3& v) { return {v.x, v.y, v.z}; }

/// Distance of a point from a triangle by projection on its plane and on each side.
double distance_from(const TriangleCorners& triangle, const Vec3& point) {
  const Long t[3] = {to_long(triangle[0]), to_long(triangle[1]), to_long(triangle[2])}, p = to_long(point);
  long double best2 = 1e300L;
  const auto take = [&](const Long& apart) { best2 = std::min(best2, dot(apart, apart)); };
  for (std::size_t k = 0; k < 3; ++k) {
    const Long e = t[(k + 1) % 3] - t[k];
    const long double l2 = dot(e, e), s = l2 > 0 ? std::clamp(dot(p - t[k], e) / l2, 0.0L, 1.0L) : 0;
    take(p - t[k] - e * s);
  }
  const Long n = cross(t[1] - t[0], t[2] - t[0]);
  if (dot(n, n) > 0) {
    bool inside = true;
    for (std::size_t k = 0; k < 3; ++k) inside = inside && dot(cross(n, t[(k + 1) % 3] - t[k]), p - t[k]) >= 0;
    // The error of a needle's normal is the rounding error divided by the needle's relative thickness. The resulting error of the height is
    // not counted.
    const Long up = n * (dot(n, p - t[0]) / dot(n, n));
    const long double longest =
        std::sqrt(std::max({dot(t[1] - t[0], t[1] - t[0]), dot(t[2] - t[1], t[2] - t[1]), dot(t[0] - t[2], t[0] - t[2])}));
    const long double height = std::sqrt(dot(up, up)), hidden = 1e-18L * longest * longest * longest / std::sqrt(dot(n, n));
    if (inside) take({std::max(height - hidden, 0.0L), 0, 0});
  }
  return static_cast<double>(std::sqrt(best2));
}

/// Upper bound of the error of d.distance, as a fraction of the maximum coordinate. It is computed from the closest points d.pa and d.pb
/// and the separating slab between them.
double proved_error(const TriangleCorners& a, const TriangleCorners& b, const TriangleDistance& d) {
  const double size = size_of(a, b), reach = size + norm(a[0]);
  const double error = std::max({distance_from(a, d.pa), distance_from(b, d.pb), std::fabs(norm(d.pa - d.pb) - d.distance)});
  if (d.distance <= 1e-14 * reach) return error / reach;
  const Vec3 n = (d.pa - d.pb) / norm(d.pa - d.pb);
  double lower = 1e300;
  for (const Vec3& v : a)
    for (const Vec3& w : b) lower = std::min(lower, dot(n, v - w));
  // The error of the normal is the error of the closest points divided by the distance. Its effect grows with the size of the triangles.
  const double known = 1e-15 * reach * std::max(1.0, size / d.distance);
  return std::max(error, d.distance - lower - known) / reach;
}

TriangleCorners random_triangle(Random& random, double size) {
  const Vec3 p = random.vec(size), a = random.unit() * (size * random.in(0.1, 1)), b = random.unit() * (size * random.in(0.1, 1));
  switch (random.below(5)) {
    case 0: return {p, p + a, p + a * random.in(-1, 2) + b * 1e-7};  // needle or cap
    case 1: return {p, p + a, p + b * 1e-7};                         // needle with a short side
    default: return {p, p + a, p + b};
  }
}

TEST(Triangle, DistanceIsCertifiedInAllPositions) {
  Random random(31);
  double worst = 0;
  int meeting = 0;
  for (int i = 0; i < 200000; ++i) {
    const double size = std::pow(10.0, random.in(-3, 3));
    const Vec3 offset = random.below(4) == 0 ? random.unit() * 1000 : Vec3{};
    TriangleCorners a = random_triangle(random, size), b = random_triangle(random, size);
    if (random.below(3) == 0) {  // parallel to a, partly in its plane
      const Vec3 moved = random.below(2) == 0 ? (a[1] - a[0]) * random.in(-2, 2) : random.vec(size);
      for (std::size_t k = 0; k < 3; ++k) b[k] = a[k] * random.in(0.999999, 1.000001) + moved;
    }
    for (std::size_t k = 0; k < 3; ++k) {
      a[k] += offset;
      b[k] += offset;
    }
    const TriangleDistance d = triangle_distance(a, b);
    ASSERT_TRUE(std::isfinite(d.distance)) << i;
    const double error = proved_error(a, b, d);
    meeting += d.distance == 0;
    worst = std::max(worst, error);
    ASSERT_LT(error, 1e-14) << "case " << i << ", distance " << d.distance << ", size " << size;
    const TriangleDistance back = triangle_distance(b, a);
    ASSERT_NEAR(d.distance, back.distance, 4e-14 * std::max(size_of(a, b), norm(offset)));
  }
  EXPECT_GT(meeting, 5000);
  RecordProperty("worst", std::to_string(worst));
}

TEST(Triangle, PiercingIsExactlyZero) {
  Random random(32);
  for (int i = 0; i < 20000; ++i) {
    // The first side of b pierces the interior of a, away from the sides of a and from its own ends.
    TriangleCorners a = random_triangle(random, 1);
    for (Vec3& v : a) v = random.vec(1);
    const Vec3 n = cross(a[1] - a[0], a[2] - a[0]);
    if (norm(n) < 0.05) continue;
    double u = random.in(0.05, 0.9), v = random.in(0.05, 0.9);
    if (u + v > 0.95) continue;
    const Vec3 x = a[0] + (a[1] - a[0]) * u + (a[2] - a[0]) * v, up = random.unit();
    if (std::fabs(dot(up, n)) < 0.05 * norm(n)) continue;
    const TriangleCorners b{x + up * random.in(0.05, 2), x - up * random.in(0.05, 2), x + random.vec(3)};
    const TriangleDistance d = triangle_distance(a, b);
    ASSERT_EQ(d.distance, 0.0) << i;
    ASSERT_LT(distance_from(a, d.pa) + distance_from(b, d.pb) + norm(d.pa - d.pb), 1e-13) << i;
    ASSERT_TRUE(triangles_meet(a, b));
  }
}

// Gaps from 1 to 1e-6, and 0, between parallel faces, crossing sides, and a corner and a face; at several scales and offsets.
TEST(Triangle, KnownGapsAreExact) {
  Random random(33);
  for (const double gap : {1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 0.0})
    for (const double scale : {1e-3, 1.0, 1e3})
      for (const double far : {0.0, 1000.0})
        for (int i = 0; i < 50; ++i) {
          const TriangleCorners flat{Vec3{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}};
          const double turn = random.in(0, 2 * pi);
          TriangleCorners cases[4][2] = {
              {flat, {Vec3{-0.5, -0.6, gap}, {0.4, -0.6, gap}, {0, 0.2, gap}}},             // face over face
              {flat, {Vec3{0.1, -0.2, gap}, {0.7, -0.6, gap + 0.4}, {0, 0.2, gap + 0.3}}},  // corner over face
              {flat,
               {Vec3{-1.7, -1 - gap, 0}, {0.5, -1 - gap, 0}, {0, -3, 0}}},  // coplanar; two parallel edges face each other across the gap
              {{Vec3{-1, 0, 0}, {1, 0, 0}, {0, 0, -1}},
               {Vec3{cos(turn), sin(turn), gap}, {-cos(turn), -sin(turn), gap}, {0, 0, gap + 1}}}};  // sides cross
          for (auto& pair : cases) {
            const Pose X = random.pose(1);
            for (auto& t : pair)
              for (Vec3& v : t) v = (X * v) * scale + Vec3{far, 0, 0};
            const TriangleDistance d = triangle_distance(pair[0], pair[1]);
            ASSERT_NEAR(d.distance, gap * scale, 1e-14 * (4 * scale + 4 * far)) << "gap " << gap << ", turn " << turn;
          }
        }
}

TEST(Triangle, DegenerateTriangles) {
  const Vec3 p{1, 2, 3}, e{1, 0, 0};
  const TriangleCorners point{p, p, p}, segment{p, p + e, p + e * 0.5}, flat{Vec3{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
  EXPECT_NEAR(triangle_distance(point, flat).distance, 3, 1e-15);
  EXPECT_NEAR(triangle_distance(flat, point).distance, 3, 1e-15);
  EXPECT_NEAR(triangle_distance(segment, flat).distance, 3, 1e-15);
  EXPECT_EQ(triangle_distance(point, point).distance, 0);
  EXPECT_NEAR(triangle_distance(point, {Vec3{1, 2, 4}, {1, 2, 4}, {1, 2, 4}}).distance, 1, 1e-15);
  EXPECT_EQ(triangle_distance(segment, segment).distance, 0);
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, inf, -inf})
    for (std::size_t k = 0; k < 3; ++k) {
      TriangleCorners broken = flat;
      broken[k].y = bad;
      EXPECT_TRUE(std::isnan(triangle_distance(broken, segment).distance));
      EXPECT_TRUE(std::isnan(triangle_distance(segment, broken).distance));
    }
}

TEST(Triangle, NearestPointAndItsFeature) {
  Random random(34);
  for (int i = 0; i < 50000; ++i) {
    const TriangleCorners t = random_triangle(random, 1);
    const Vec3 p = random.vec(2);
    const TrianglePoint x = nearest_on_triangle(t, p);
    ASSERT_NEAR(norm(p - x.p), distance_from(t, p), 1e-9);
    ASSERT_LT(distance_from(t, x.p), 1e-14);
  }
  const TriangleCorners t{Vec3{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  EXPECT_EQ(nearest_on_triangle(t, {0.2, 0.2, 1}).feature, TriangleFeature::face);
  EXPECT_EQ(nearest_on_triangle(t, {0.5, -1, 1}).feature, TriangleFeature::side_0);
  EXPECT_EQ(nearest_on_triangle(t, {1, 1, 1}).feature, TriangleFeature::side_1);
  EXPECT_EQ(nearest_on_triangle(t, {-1, 0.5, 1}).feature, TriangleFeature::side_2);
  EXPECT_EQ(nearest_on_triangle(t, {-1, -1, 1}).feature, TriangleFeature::corner_0);
  EXPECT_EQ(nearest_on_triangle(t, {3, 0, 1}).feature, TriangleFeature::corner_1);
  EXPECT_EQ(nearest_on_triangle(t, {0, 3, 1}).feature, TriangleFeature::corner_2);
}

}  // namespace
}  // namespace ugoki::collision
