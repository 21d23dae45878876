#pragma once
// Unit quaternions and rotation matrices. q_AB and R_AB map coordinates in B to coordinates in A.

#include "ugoki/spatial/elementary.h"
#include "ugoki/spatial/vec3.h"

namespace ugoki {

/// Unit quaternion, w first.
struct Quat {
  double w = 1, x = 0, y = 0, z = 0;

  [[nodiscard]] Vec3 vec() const { return {x, y, z}; }
  [[nodiscard]] Quat conjugate() const { return {w, -x, -y, -z}; }
  friend bool operator==(const Quat&, const Quat&) = default;
};

inline Quat operator*(const Quat& a, const Quat& b) {
  return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
          a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}

inline Quat normalized(const Quat& q) {
  const double n = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  return n > 1e-300 ? Quat{q.w / n, q.x / n, q.y / n, q.z / n} : Quat{};
}

inline Mat3 to_matrix(const Quat& q) {
  const double xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z;
  const double xy = q.x * q.y, xz = q.x * q.z, yz = q.y * q.z;
  const double wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z;
  return {1 - 2 * (yy + zz), 2 * (xy - wz), 2 * (xz + wy), 2 * (xy + wz),    1 - 2 * (xx + zz),
          2 * (yz - wx),     2 * (xz - wy), 2 * (yz + wx), 1 - 2 * (xx + yy)};
}

/// Rotates v by q.
inline Vec3 rotate(const Quat& q, const Vec3& v) { return to_matrix(q) * v; }

/// Quaternion of a rotation matrix, with w >= 0. Shepperd's method: divides by a quaternion component that is not small.
[[nodiscard]] Quat to_quat(const Mat3& R);

/// Rotation by `angle` [rad] about the unit vector `axis`.
inline Quat axis_angle(const Vec3& axis, double angle) {
  const SinCos sc = sin_cos(0.5 * angle);
  return {sc.cos, axis.x * sc.sin, axis.y * sc.sin, axis.z * sc.sin};
}
inline Mat3 rotation_about(const Vec3& axis, double angle) { return to_matrix(axis_angle(axis, angle)); }

/// Exponential map: rotation by |r| [rad] about the direction of r.
[[nodiscard]] Quat exp_map(const Vec3& r);
/// Inverse of exp_map: rotation vector with length in [0, pi].
[[nodiscard]] Vec3 log_map(const Quat& q);

/// Spherical linear interpolation along the shorter great arc from a (t = 0) to b (t = 1).
[[nodiscard]] Quat slerp(const Quat& a, const Quat& b, double t);

/// Shortest rotation that turns unit vector `from` into unit vector `to`.
[[nodiscard]] Quat rotation_between(const Vec3& from, const Vec3& to);

/// Euler angles [rad] about the axes named by `order` (for example "ZXY"), so that
/// R = R_order[0](a0) R_order[1](a1) R_order[2](a2); a1 in [-pi/2, pi/2]. At gimbal lock a2 = 0.
/// @param order three different letters of X, Y, Z
[[nodiscard]] Vec3 to_euler(const Mat3& R, const char* order);
/// Inverse of to_euler: R_order[0](angles.x) R_order[1](angles.y) R_order[2](angles.z).
[[nodiscard]] Mat3 from_euler(const Vec3& angles, const char* order);

/// Returns a unit vector, otherwise arbitrary, that is perpendicular to the unit vector `n`.
[[nodiscard]] Vec3 any_perpendicular(const Vec3& n);

}  // namespace ugoki
