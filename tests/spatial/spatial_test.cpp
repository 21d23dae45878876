// Compares the compact forms of 6-D algebra with plain 6 x 6 matrices.

#include "ugoki/spatial/spatial.h"

#include <gtest/gtest.h>

#include <array>
#include <random>

namespace ugoki {
namespace {

using Matrix6 = std::array<std::array<double, 6>, 6>;

class Random {
 public:
  double in(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  Vec3 vec() { return {in(-1, 1), in(-1, 1), in(-1, 1)}; }
  Vec6 vec6() { return {vec(), vec()}; }
  Pose pose() { return {rotation_about(normalized(vec()), in(-pi, pi)), vec() * 2.0}; }
  /// Inertia of five random point masses.
  Inertia inertia() {
    Inertia sum;
    for (int i = 0; i < 5; ++i) sum += Inertia::from_centre(in(0.1, 2), vec(), {});
    return sum;
  }

 private:
  std::mt19937_64 engine_{3};
};

Matrix6 blocks(const Mat3& a, const Mat3& b, const Mat3& c, const Mat3& d) {
  Matrix6 out{};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const auto r = static_cast<std::size_t>(i), s = static_cast<std::size_t>(j);
      out[r][s] = a.row(i)[j];
      out[r][s + 3] = b.row(i)[j];
      out[r + 3][s] = c.row(i)[j];
      out[r + 3][s + 3] = d.row(i)[j];
    }
  return out;
}
/// Matrix that converts motion vectors from frame B to frame A: [R 0; p x R, R]. X = (R, p) is the pose of B in A.
Matrix6 motion_matrix(const Pose& X) { return blocks(X.R, {}, Mat3::skew(X.p) * X.R, X.R); }
/// Matrix that converts force vectors from frame B to frame A: [R, p x R; 0, R]. X = (R, p) is the pose of B in A.
Matrix6 force_matrix(const Pose& X) { return blocks(X.R, Mat3::skew(X.p) * X.R, {}, X.R); }
Matrix6 matrix(const Inertia& i) { return blocks(i.I.matrix(), Mat3::skew(i.h), Mat3::skew(i.h).transposed(), Mat3::identity() * i.mass); }
Vec6 times(const Matrix6& m, const Vec6& v) {
  const double in[6] = {v.w.x, v.w.y, v.w.z, v.v.x, v.v.y, v.v.z};
  double out[6] = {};
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j < 6; ++j) out[i] += m[i][j] * in[j];
  return {{out[0], out[1], out[2]}, {out[3], out[4], out[5]}};
}
double size(const Vec6& v) { return norm(v.w) + norm(v.v); }

TEST(Spatial, TransformsEqualTheirMatrices) {
  Random random;
  for (int i = 0; i < 1000; ++i) {
    const Pose X = random.pose();
    const Vec6 m = random.vec6();
    ASSERT_LT(size(X.motion_to_parent(m) - times(motion_matrix(X), m)), 2e-14);
    ASSERT_LT(size(X.force_to_parent(m) - times(force_matrix(X), m)), 2e-14);
    ASSERT_LT(size(X.motion_to_child(X.motion_to_parent(m)) - m), 2e-14);
    ASSERT_LT(size(X.force_to_child(X.force_to_parent(m)) - m), 2e-14);
    ASSERT_LT(size(X.motion_to_child(m) - X.inverse().motion_to_parent(m)), 2e-14);
    ASSERT_LT(size(X.force_to_child(m) - X.inverse().force_to_parent(m)), 2e-14);
  }
}

TEST(Spatial, PosesCompose) {
  Random random;
  for (int i = 0; i < 1000; ++i) {
    const Pose A = random.pose(), B = random.pose();
    const Vec3 p = random.vec();
    ASSERT_LT(norm((A * B) * p - A * (B * p)), 1e-14);
    ASSERT_LT(norm(A.inverse() * (A * p) - p), 1e-14);
    const Vec6 m = random.vec6();
    ASSERT_LT(size((A * B).motion_to_parent(m) - A.motion_to_parent(B.motion_to_parent(m))), 5e-14);
  }
}

TEST(Spatial, PowerIsTheSameInEveryFrame) {
  Random random;
  for (int i = 0; i < 1000; ++i) {
    const Pose X = random.pose();
    const Vec6 m = random.vec6(), f = random.vec6();
    ASSERT_NEAR(dot(X.motion_to_parent(m), X.force_to_parent(f)), dot(m, f), 3e-14);
  }
}

TEST(Spatial, CrossProducts) {
  Random random;
  for (int i = 0; i < 1000; ++i) {
    const Vec6 a = random.vec6(), b = random.vec6(), f = random.vec6();
    const Matrix6 motion = blocks(Mat3::skew(a.w), {}, Mat3::skew(a.v), Mat3::skew(a.w));
    const Matrix6 force = blocks(Mat3::skew(a.w), Mat3::skew(a.v), {}, Mat3::skew(a.w));
    ASSERT_LT(size(cross_motion(a, b) - times(motion, b)), 1e-14);
    ASSERT_LT(size(cross_force(a, f) - times(force, f)), 1e-14);
    ASSERT_LT(size(cross_motion(a, a)), 1e-15);
    ASSERT_NEAR(dot(cross_motion(a, b), f), -dot(b, cross_force(a, f)), 1e-14);  // a x* = -(a x)^T
  }
}

TEST(Spatial, InertiaTimesMotion) {
  Random random;
  for (int i = 0; i < 1000; ++i) {
    const Inertia body = random.inertia();
    const Vec6 m = random.vec6();
    ASSERT_LT(size(body * m - times(matrix(body), m)), 1e-13);
    ASSERT_GT(dot(m, body * m), 0);  // twice the kinetic energy
  }
}

TEST(Spatial, InertiaInAnotherFrame) {
  Random random;
  for (int i = 0; i < 1000; ++i) {
    const Pose X = random.pose();
    const Inertia body = random.inertia(), there = body.in_parent(X);
    const Vec6 m = random.vec6();
    // I_A = X_f I_B X_m^-1
    const Vec6 expected = times(force_matrix(X), times(matrix(body), times(motion_matrix(X.inverse()), m)));
    ASSERT_LT(size(there * m - expected), 1e-12);
    ASSERT_LT(norm(there.centre() - X * body.centre()), 1e-14);
    ASSERT_DOUBLE_EQ(there.mass, body.mass);
    const Inertia back = there.in_parent(X.inverse());
    ASSERT_LT(size(back * m - body * m), 1e-12);
  }
}

TEST(Spatial, ParallelAxisTheorem) {
  const Sym3 about_centre{1, 2, 2.5, 0.1, -0.2, 0.3};
  const Inertia body = Inertia::from_centre(3, {0, 0, 2}, about_centre);
  EXPECT_DOUBLE_EQ(body.I.xx, 1 + 3 * 4);
  EXPECT_DOUBLE_EQ(body.I.yy, 2 + 3 * 4);
  EXPECT_DOUBLE_EQ(body.I.zz, 2.5);
  EXPECT_DOUBLE_EQ(body.h.z, 6);
  const Sym3 back = body.about_centre();
  EXPECT_NEAR(back.xx, 1, 1e-14);
  EXPECT_NEAR(back.xz, -0.2, 1e-14);
  EXPECT_EQ(Inertia{}.centre(), Vec3{});
}

TEST(Spatial, SymmetricMatrices) {
  Random random;
  const Sym3 s{1, 2, 3, 4, 5, 6};
  EXPECT_EQ(s * (Vec3{1, 2, 3}), (s.matrix() * Vec3{1, 2, 3}));
  const Mat3 R = random.pose().R;
  const Mat3 expected = R * s.matrix() * R.transposed();
  const Mat3 turned = rotated(s, R).matrix();
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) EXPECT_NEAR(turned.row(i)[j], expected.row(i)[j], 1e-14);
  const Vec3 c{1, 2, 3}, w{0.3, -0.1, 0.7};
  EXPECT_LT(norm(point_inertia(c) * w - cross(c, cross(w, c))), 1e-14);  // c x (w x c)
}

TEST(Spatial, VectorsAndMatrices) {
  const Vec3 a{1, 2, 3}, b{-4, 5, 0.5};
  EXPECT_EQ(Mat3::skew(a) * b, cross(a, b));
  EXPECT_EQ(Mat3::outer(a, b) * a, a * dot(b, a));
  EXPECT_EQ(transpose_times(Mat3::outer(a, b), a), Mat3::outer(a, b).transposed() * a);
  const Mat3 m{2, 1, 0, -1, 3, 1, 0.5, 0, 4};
  EXPECT_DOUBLE_EQ(m.determinant(), 2 * 12 - 1 * (-4 - 0.5));
  const Mat3 one = m * inverse(m);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) EXPECT_NEAR(one.row(i)[j], i == j ? 1 : 0, 1e-15);
  EXPECT_FALSE(is_finite(Vec3{0, std::numeric_limits<double>::infinity(), 0}));
}

}  // namespace
}  // namespace ugoki
