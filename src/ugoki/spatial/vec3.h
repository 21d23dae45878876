#pragma once
// 3-D vectors and 3 x 3 matrices. T: double, float, or a SIMD lane type with the same operators.

#include <cmath>

namespace ugoki {

template <class T>
struct Vec3T {
  T x{}, y{}, z{};

  friend constexpr Vec3T operator+(const Vec3T& a, const Vec3T& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend constexpr Vec3T operator-(const Vec3T& a, const Vec3T& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend constexpr Vec3T operator-(const Vec3T& a) { return {-a.x, -a.y, -a.z}; }
  friend constexpr Vec3T operator*(const Vec3T& a, T s) { return {a.x * s, a.y * s, a.z * s}; }
  friend constexpr Vec3T operator*(T s, const Vec3T& a) { return {a.x * s, a.y * s, a.z * s}; }
  friend constexpr Vec3T operator/(const Vec3T& a, T s) { return {a.x / s, a.y / s, a.z / s}; }
  constexpr Vec3T& operator+=(const Vec3T& b) { return *this = *this + b; }
  constexpr Vec3T& operator-=(const Vec3T& b) { return *this = *this - b; }
  constexpr Vec3T& operator*=(T s) { return *this = *this * s; }
  friend constexpr bool operator==(const Vec3T&, const Vec3T&) = default;

  constexpr T& operator[](int i) { return i == 0 ? x : i == 1 ? y : z; }
  constexpr const T& operator[](int i) const { return i == 0 ? x : i == 1 ? y : z; }
};

template <class T>
constexpr T dot(const Vec3T<T>& a, const Vec3T<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
constexpr Vec3T<T> cross(const Vec3T<T>& a, const Vec3T<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class T>
T norm(const Vec3T<T>& a) {
  using std::sqrt;
  return sqrt(dot(a, a));
}
/// Unit vector along `a`; `fallback` if |a| <= 1e-300.
inline Vec3T<double> normalized(const Vec3T<double>& a, const Vec3T<double>& fallback = {0, 0, 1}) {
  const double n = norm(a);
  return n > 1e-300 ? a / n : fallback;
}
inline bool is_finite(const Vec3T<double>& a) { return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z); }

/// 3 x 3 matrix, row-major.
template <class T>
struct Mat3T {
  T xx{}, xy{}, xz{};
  T yx{}, yy{}, yz{};
  T zx{}, zy{}, zz{};

  static constexpr Mat3T identity() { return {T(1), T(0), T(0), T(0), T(1), T(0), T(0), T(0), T(1)}; }
  static constexpr Mat3T diagonal(T a, T b, T c) { return {a, T(0), T(0), T(0), b, T(0), T(0), T(0), c}; }
  /// Matrix of the cross product: skew(a) b = a x b.
  static constexpr Mat3T skew(const Vec3T<T>& a) { return {T(0), -a.z, a.y, a.z, T(0), -a.x, -a.y, a.x, T(0)}; }
  static constexpr Mat3T columns(const Vec3T<T>& a, const Vec3T<T>& b, const Vec3T<T>& c) {
    return {a.x, b.x, c.x, a.y, b.y, c.y, a.z, b.z, c.z};
  }
  /// Outer product a b^T.
  static constexpr Mat3T outer(const Vec3T<T>& a, const Vec3T<T>& b) {
    return {a.x * b.x, a.x * b.y, a.x * b.z, a.y * b.x, a.y * b.y, a.y * b.z, a.z * b.x, a.z * b.y, a.z * b.z};
  }

  constexpr Vec3T<T> row(int i) const { return i == 0 ? Vec3T<T>{xx, xy, xz} : i == 1 ? Vec3T<T>{yx, yy, yz} : Vec3T<T>{zx, zy, zz}; }
  constexpr Vec3T<T> column(int i) const { return i == 0 ? Vec3T<T>{xx, yx, zx} : i == 1 ? Vec3T<T>{xy, yy, zy} : Vec3T<T>{xz, yz, zz}; }
  constexpr Mat3T transposed() const { return {xx, yx, zx, xy, yy, zy, xz, yz, zz}; }
  constexpr T trace() const { return xx + yy + zz; }
  constexpr T determinant() const { return dot(row(0), cross(row(1), row(2))); }

  friend constexpr Vec3T<T> operator*(const Mat3T& m, const Vec3T<T>& v) {
    return {m.xx * v.x + m.xy * v.y + m.xz * v.z, m.yx * v.x + m.yy * v.y + m.yz * v.z, m.zx * v.x + m.zy * v.y + m.zz * v.z};
  }
  /// m^T v, without forming the transpose.
  friend constexpr Vec3T<T> transpose_times(const Mat3T& m, const Vec3T<T>& v) {
    return {m.xx * v.x + m.yx * v.y + m.zx * v.z, m.xy * v.x + m.yy * v.y + m.zy * v.z, m.xz * v.x + m.yz * v.y + m.zz * v.z};
  }
  friend constexpr Mat3T operator*(const Mat3T& a, const Mat3T& b) { return columns(a * b.column(0), a * b.column(1), a * b.column(2)); }
  friend constexpr Mat3T operator*(const Mat3T& a, T s) {
    return {a.xx * s, a.xy * s, a.xz * s, a.yx * s, a.yy * s, a.yz * s, a.zx * s, a.zy * s, a.zz * s};
  }
  friend constexpr Mat3T operator+(const Mat3T& a, const Mat3T& b) {
    return {a.xx + b.xx, a.xy + b.xy, a.xz + b.xz, a.yx + b.yx, a.yy + b.yy, a.yz + b.yz, a.zx + b.zx, a.zy + b.zy, a.zz + b.zz};
  }
  friend constexpr Mat3T operator-(const Mat3T& a, const Mat3T& b) { return a + b * T(-1); }
  constexpr Mat3T& operator+=(const Mat3T& b) { return *this = *this + b; }
  constexpr Mat3T& operator-=(const Mat3T& b) { return *this = *this - b; }
  friend constexpr bool operator==(const Mat3T&, const Mat3T&) = default;
};

using Vec3 = Vec3T<double>;
using Mat3 = Mat3T<double>;

/// Inverse of a well-conditioned matrix (adjugate divided by determinant). No check for singular matrices.
inline Mat3 inverse(const Mat3& m) {
  const Vec3 a = m.row(0), b = m.row(1), c = m.row(2);
  const Vec3 bc = cross(b, c), ca = cross(c, a), ab = cross(a, b);
  return Mat3::columns(bc, ca, ab) * (1.0 / dot(a, bc));
}

}  // namespace ugoki
