#include "ugoki/spatial/rotation.h"

#include "ugoki/base/check.h"

namespace ugoki {

Quat to_quat(const Mat3& R) {
  Quat q;
  if (R.trace() > 0) {
    const double s = std::sqrt(R.trace() + 1.0);
    const double f = 0.5 / s;
    q = {0.5 * s, (R.zy - R.yz) * f, (R.xz - R.zx) * f, (R.yx - R.xy) * f};
  } else if (R.xx >= R.yy && R.xx >= R.zz) {
    const double s = std::sqrt(1.0 + R.xx - R.yy - R.zz);
    const double f = 0.5 / s;
    q = {(R.zy - R.yz) * f, 0.5 * s, (R.xy + R.yx) * f, (R.xz + R.zx) * f};
  } else if (R.yy >= R.zz) {
    const double s = std::sqrt(1.0 + R.yy - R.xx - R.zz);
    const double f = 0.5 / s;
    q = {(R.xz - R.zx) * f, (R.xy + R.yx) * f, 0.5 * s, (R.yz + R.zy) * f};
  } else {
    const double s = std::sqrt(1.0 + R.zz - R.xx - R.yy);
    const double f = 0.5 / s;
    q = {(R.yx - R.xy) * f, (R.xz + R.zx) * f, (R.yz + R.zy) * f, 0.5 * s};
  }
  if (q.w < 0) q = {-q.w, -q.x, -q.y, -q.z};
  return normalized(q);
}

Quat exp_map(const Vec3& r) {
  // x: square of half the angle a. Up to a = 0.5 rad, sin(a/2) / a and cos(a/2) are computed from their series; the omitted terms are below
  // 1e-19. The quaternion then has unit length up to rounding.
  const double x = 0.25 * dot(r, r);
  if (x < 0.0625) {
    const double f =
        0.5 *
        (1 + x * (-1.0 / 6 + x * (1.0 / 120 + x * (-1.0 / 5040 + x * (1.0 / 362880 + x * (-1.0 / 39916800 + x * (1.0 / 6227020800.0)))))));
    const double w =
        1 + x * (-1.0 / 2 + x * (1.0 / 24 + x * (-1.0 / 720 + x * (1.0 / 40320 + x * (-1.0 / 3628800 + x * (1.0 / 479001600.0))))));
    return {w, r.x * f, r.y * f, r.z * f};
  }
  const double angle = norm(r);
  const SinCos half = sin_cos(0.5 * angle);
  const double f = half.sin / angle;
  return normalized(Quat{half.cos, r.x * f, r.y * f, r.z * f});
}

Vec3 log_map(const Quat& q_in) {
  const Quat q = q_in.w < 0 ? Quat{-q_in.w, -q_in.x, -q_in.y, -q_in.z} : q_in;
  const double s = norm(q.vec());
  if (s < 1e-10) return q.vec() * 2.0;
  return q.vec() * (2.0 * atan2(s, q.w) / s);
}

Quat slerp(const Quat& a, const Quat& b, double t) { return normalized(a * exp_map(log_map(a.conjugate() * b) * t)); }

Quat rotation_between(const Vec3& from, const Vec3& to) {
  const double c = dot(from, to);
  const Vec3 n = cross(from, to);
  if (c > -0.5) return normalized(Quat{1.0 + c, n.x, n.y, n.z});
  // For nearly opposite directions the cross product n is inaccurate. Rotate `from` to -to first, then by half a turn to `to`, about the
  // part of the axis that is perpendicular to `to`.
  const double length = norm(n);
  const Vec3 axis = length > 1e-12 ? n / length : any_perpendicular(to);
  const Vec3 across = normalized(axis - to * dot(to, axis));
  return Quat{0, across.x, across.y, across.z} * rotation_between(from, -to);
}

namespace {
int axis_index(char c) {
  const int i = c == 'X' || c == 'x' ? 0 : c == 'Y' || c == 'y' ? 1 : c == 'Z' || c == 'z' ? 2 : -1;
  UGOKI_CHECK(i >= 0);
  return i;
}
Vec3 unit(int i) { return {i == 0 ? 1.0 : 0.0, i == 1 ? 1.0 : 0.0, i == 2 ? 1.0 : 0.0}; }
}  // namespace

Mat3 from_euler(const Vec3& a, const char* order) {
  return rotation_about(unit(axis_index(order[0])), a.x) * rotation_about(unit(axis_index(order[1])), a.y) *
         rotation_about(unit(axis_index(order[2])), a.z);
}

Vec3 to_euler(const Mat3& R, const char* order) {
  const int i = axis_index(order[0]), j = axis_index(order[1]), k = axis_index(order[2]);
  const double sign = (j - i + 3) % 3 == 1 ? 1.0 : -1.0;  // +1 for cyclic orders XYZ, YZX, ZXY
  const auto at = [&](int r, int c) { return R.row(r)[c]; };
  const double s1 = sign * at(i, k);
  const double c1 = std::sqrt(at(i, i) * at(i, i) + at(i, j) * at(i, j));
  const double a1 = atan2(s1, c1);
  if (c1 > 1e-12) return {atan2(-sign * at(j, k), at(k, k)), a1, atan2(-sign * at(i, j), at(i, i))};
  return {atan2(sign * at(k, j), at(j, j)), a1, 0.0};
}

Vec3 any_perpendicular(const Vec3& n) {
  // At least one component of a unit vector is below 1/sqrt(3) = 0.577. The first one below 0.6 is taken, not the smallest one, so that
  // rounding does not turn the result by a right angle when n is close to an axis or a diagonal.
  constexpr double small = 0.6;
  const Vec3 e = std::fabs(n.x) <= small ? Vec3{1, 0, 0} : std::fabs(n.y) <= small ? Vec3{0, 1, 0} : Vec3{0, 0, 1};
  return normalized(cross(n, e));
}

}  // namespace ugoki
