#include "ugoki/spatial/rotation.h"

#include <gtest/gtest.h>

#include <random>

#include "ugoki/spatial/elementary.h"
#include "ugoki/spatial/heading.h"

namespace ugoki {
namespace {

class Random {
 public:
  double in(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  Vec3 unit() {
    for (;;) {
      const Vec3 v{in(-1, 1), in(-1, 1), in(-1, 1)};
      if (norm(v) > 0.1 && norm(v) < 1) return v / norm(v);
    }
  }
  Quat quat() { return axis_angle(unit(), in(-pi, pi)); }

 private:
  std::mt19937_64 engine_{77};
};

double difference(const Mat3& a, const Mat3& b) {
  double worst = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) worst = std::max(worst, std::fabs(a.row(i)[j] - b.row(i)[j]));
  return worst;
}
/// Largest difference of the components of two quaternions, after choosing the sign of b: q and -q are the same rotation.
double difference(const Quat& a, const Quat& b) {
  const double d = a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z;
  const Quat s = d < 0 ? Quat{-b.w, -b.x, -b.y, -b.z} : b;
  return std::max({std::fabs(a.w - s.w), std::fabs(a.x - s.x), std::fabs(a.y - s.y), std::fabs(a.z - s.z)});
}

TEST(Rotation, QuarterTurnsAboutTheAxes) {
  EXPECT_LT(norm(rotate(axis_angle({0, 0, 1}, pi / 2), {1, 0, 0}) - Vec3{0, 1, 0}), 1e-15);
  EXPECT_LT(norm(rotate(axis_angle({1, 0, 0}, pi / 2), {0, 1, 0}) - Vec3{0, 0, 1}), 1e-15);
  EXPECT_LT(norm(rotate(axis_angle({0, 1, 0}, pi / 2), {0, 0, 1}) - Vec3{1, 0, 0}), 1e-15);
  EXPECT_EQ(difference(to_matrix(Quat{}), Mat3::identity()), 0);
}

TEST(Rotation, RodriguesFormula) {
  Random random;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 n = random.unit(), v = random.unit();
    const double a = random.in(-4, 4);
    const Vec3 expected = v * std::cos(a) + cross(n, v) * std::sin(a) + n * (dot(n, v) * (1 - std::cos(a)));
    ASSERT_LT(norm(rotation_about(n, a) * v - expected), 3e-15);
  }
}

TEST(Rotation, ProductsAndInverses) {
  Random random;
  for (int i = 0; i < 2000; ++i) {
    const Quat a = random.quat(), b = random.quat();
    ASSERT_LT(difference(to_matrix(a * b), to_matrix(a) * to_matrix(b)), 3e-15);
    ASSERT_LT(difference(a * a.conjugate(), Quat{}), 1e-15);
    ASSERT_LT(difference(to_matrix(a.conjugate()), to_matrix(a).transposed()), 1e-15);
    ASSERT_NEAR(to_matrix(a).determinant(), 1, 3e-15);
    ASSERT_LT(difference(inverse(to_matrix(a)), to_matrix(a).transposed()), 5e-15);
  }
}

TEST(Rotation, MatrixToQuaternionAndBack) {
  Random random;
  for (int i = 0; i < 20000; ++i) {
    const Quat q = random.quat(), back = to_quat(to_matrix(q));
    ASSERT_LT(difference(q, back), 2e-15);
    ASSERT_GE(back.w, 0);
  }
  // Half turns: the trace is at its minimum -1, and each of x, y, z is the largest component once.
  for (const Vec3 n :
       {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}, Vec3{std::sqrt(0.5), std::sqrt(0.5), 0}, Vec3{0, std::sqrt(0.5), -std::sqrt(0.5)}})
    EXPECT_LT(difference(to_quat(rotation_about(n, pi)), axis_angle(n, pi)), 1e-15);
}

TEST(Rotation, ExponentialAndLogarithm) {
  Random random;
  for (int i = 0; i < 20000; ++i) {
    const double length = i % 3 == 0 ? random.in(0, pi * 0.999) : std::pow(10.0, random.in(-12, 0.49));
    const Vec3 r = random.unit() * length;
    ASSERT_LT(norm(log_map(exp_map(r)) - r), 2e-15 * (1 + length) + 1e-15 * length) << length;
    ASSERT_LT(difference(to_matrix(exp_map(r)), rotation_about(normalized(r), norm(r))), 3e-15);
  }
  EXPECT_EQ(log_map(Quat{}), Vec3{});
  EXPECT_EQ(exp_map(Vec3{}), Quat{});
  EXPECT_NEAR(norm(log_map(axis_angle({0, 0, 1}, pi))), pi, 1e-15);
  EXPECT_NEAR(norm(log_map(axis_angle({0, 0, 1}, 1.5 * pi))), 0.5 * pi, 1e-14);  // the rotation vector of the shorter direction, 0.5 pi
}

TEST(Rotation, SlerpIsAGreatArcAtConstantSpeed) {
  Random random;
  for (int i = 0; i < 2000; ++i) {
    const Quat a = random.quat(), b = random.quat();
    ASSERT_LT(difference(slerp(a, b, 0), a), 2e-15);
    ASSERT_LT(difference(slerp(a, b, 1), b), 5e-15);
    const double angle = norm(log_map(a.conjugate() * b));
    ASSERT_LE(angle, pi + 1e-15);
    if (angle > pi - 1e-3) continue;  // nearly opposite: rounding decides which of the two arcs is shorter
    const double t = random.in(0, 1);
    const Quat c = slerp(a, b, t);
    ASSERT_NEAR(norm(log_map(a.conjugate() * c)), t * angle, 1e-14);
    ASSERT_NEAR(norm(log_map(c.conjugate() * b)), (1 - t) * angle, 1e-14);
  }
  const Quat q = axis_angle({0, 0, 1}, 1), minus{-q.w, -q.x, -q.y, -q.z};
  EXPECT_LT(difference(slerp(q, minus, 0.5), q), 1e-15);  // -q is the same rotation as q
}

TEST(Rotation, BetweenTwoDirections) {
  Random random;
  for (int i = 0; i < 5000; ++i) {
    const Vec3 a = random.unit(), b = random.unit();
    const Quat q = rotation_between(a, b);
    ASSERT_LT(norm(rotate(q, a) - b), 1e-14);
    ASSERT_LT(std::fabs(dot(q.vec(), a)), 1e-13);  // the axis of the shortest rotation is perpendicular to both vectors
  }
  for (double off = 1; off > 1e-18; off *= 0.3) {  // b approaches -a
    for (const double sign : {1.0, -1.0}) {
      const Vec3 a = random.unit(), b = normalized(a * sign + any_perpendicular(a) * off);
      const Quat q = rotation_between(a, b);
      ASSERT_LT(norm(rotate(q, a) - b), 1e-13) << off;
      ASSERT_NEAR(q.w * q.w + dot(q.vec(), q.vec()), 1, 1e-14);
    }
  }
  EXPECT_EQ(rotation_between({0, 0, 1}, {0, 0, 1}), Quat{});
}

TEST(Rotation, EulerAnglesOfAllOrders) {
  Random random;
  for (const char* order : {"XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX"}) {
    for (int i = 0; i < 3000; ++i) {
      const Vec3 angles{random.in(-pi, pi), random.in(-pi / 2, pi / 2), random.in(-pi, pi)};
      const Mat3 R = from_euler(angles, order);
      const Vec3 back = to_euler(R, order);
      ASSERT_LT(difference(from_euler(back, order), R), 5e-15);
      if (std::fabs(angles.y) < 1.5) {
        ASSERT_LT(norm(back - angles), 1e-13) << order;
      }
    }
    for (const double pole : {pi / 2, -pi / 2, pi / 2 - 1e-9, -pi / 2 + 1e-13, pi / 2 - 1e-15}) {
      const Mat3 R = from_euler({0.7, pole, -0.4}, order);
      EXPECT_LT(difference(from_euler(to_euler(R, order), order), R), 3e-12) << order << " " << pole;
    }
    EXPECT_EQ(to_euler(from_euler({0.7, pi / 2, -0.4}, order), order).z, 0) << order;
  }
  // Independent of from_euler: R = Z(a) X(b) Y(c).
  const Mat3 R = rotation_about({0, 0, 1}, 0.3) * rotation_about({1, 0, 0}, -0.5) * rotation_about({0, 1, 0}, 1.1);
  EXPECT_LT(difference(from_euler({0.3, -0.5, 1.1}, "ZXY"), R), 1e-15);
}

TEST(Rotation, AnyPerpendicularIsAUnitVectorAtARightAngle) {
  Random random;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 n = i < 3 ? Vec3{i == 0 ? 1.0 : 0.0, i == 1 ? 1.0 : 0.0, i == 2 ? 1.0 : 0.0} : random.unit();
    const Vec3 p = any_perpendicular(n);
    ASSERT_NEAR(norm(p), 1, 1e-15);
    ASSERT_NEAR(dot(p, n), 0, 1e-15);
  }
}

TEST(Rotation, NormalizedZeroGivesTheFallback) {
  EXPECT_EQ(normalized(Quat{0, 0, 0, 0}), Quat{});
  EXPECT_EQ(normalized(Vec3{0, 0, 0}, Vec3{1, 0, 0}), (Vec3{1, 0, 0}));
}

}  // namespace
TEST(Heading, TurnsWithTheOrientation) {
  Random random;
  for (int trial = 0; trial < 200; ++trial) {
    const Mat3 R = to_matrix(random.quat());
    const double angle = random.in(-4, 4);
    const Mat3 Z = rotation_about({0, 0, 1}, angle);
    const Vec3 h = heading_of(R), t = perpendicular_along(R.column(0), h);
    EXPECT_NEAR(norm(h), 1, 1e-12);
    EXPECT_EQ(h.z, 0);
    EXPECT_LT(norm(heading_of(Z * R) - Z * h), 1e-9);
    EXPECT_LT(norm(perpendicular_along(Z * R.column(0), Z * h) - Z * t), 1e-9);
    EXPECT_NEAR(dot(t, R.column(0)), 0, 1e-12);
    EXPECT_GE(dot(t, h), 0);
    // A tilt about a horizontal axis by less than pi does not change the heading.
    const Mat3 tilt = rotation_about({cos(angle), sin(angle), 0}, random.in(-3, 3));
    EXPECT_LT(norm(heading_of(tilt * Z) - Z.column(0)), 1e-9);
  }
  EXPECT_EQ(heading_of(rotation_about({0, 1, 0}, pi)).z, 0);
  EXPECT_NEAR(norm(perpendicular_along({0, 0, 1}, {0, 0, 1})), 1, 1e-12);
}

}  // namespace ugoki
