#pragma once
// Double-double arithmetic: values with about 32 decimal digits, stored as the sum of two doubles. Used where the sign of a difference of
// products decides a branch.
// Source: Dekker, A floating-point technique for extending the available precision (1971).

#include "ugoki/spatial/vec3.h"

namespace ugoki::collision {

/// A number stored as the unevaluated sum high + low.
struct DoubleDouble {
  double high = 0, low = 0;

  /// a + b without error.
  static DoubleDouble sum(double a, double b) {
    const double s = a + b, t = s - a;
    return {s, (a - (s - t)) + (b - t)};
  }
  /// a * b without error, for magnitudes below 1e290.
  static DoubleDouble product(double a, double b) {
    constexpr double split = 134217729.0;  // 2^27 + 1 splits a double into two halves of 26 bits (Dekker, Veltkamp)
    const double p = a * b, ca = split * a, cb = split * b;
    const double ah = ca - (ca - a), al = a - ah, bh = cb - (cb - b), bl = b - bh;
    return {p, ((ah * bh - p) + ah * bl + al * bh) + al * bl};
  }
  friend DoubleDouble operator+(DoubleDouble a, DoubleDouble b) {
    const DoubleDouble s = sum(a.high, b.high);
    return sum(s.high, s.low + (a.low + b.low));
  }
  friend DoubleDouble operator-(DoubleDouble a, DoubleDouble b) { return a + DoubleDouble{-b.high, -b.low}; }
  friend DoubleDouble operator*(DoubleDouble a, DoubleDouble b) {
    const DoubleDouble p = product(a.high, b.high);
    return sum(p.high, p.low + (a.high * b.low + a.low * b.high));
  }
};

/// Vector of three double-double coordinates.
struct DoubleDoubleVec {
  DoubleDouble x, y, z;
};

/// a - b without error.
inline DoubleDoubleVec exact_difference(const Vec3& a, const Vec3& b) {
  return {DoubleDouble::sum(a.x, -b.x), DoubleDouble::sum(a.y, -b.y), DoubleDouble::sum(a.z, -b.z)};
}
inline DoubleDoubleVec cross(const DoubleDoubleVec& a, const DoubleDoubleVec& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline DoubleDouble dot(const DoubleDoubleVec& a, const DoubleDoubleVec& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

}  // namespace ugoki::collision
