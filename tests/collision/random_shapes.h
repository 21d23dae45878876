#pragma once
// Random shapes and poses, and support functions shared by the oracles.

#include <algorithm>
#include <cmath>
#include <random>

#include "ugoki/mechanism/shape.h"

namespace ugoki::collision::test {

inline constexpr unsigned seed = 20260;

class Random {
 public:
  explicit Random(unsigned s = seed) : engine_(s) {}
  double in(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  int below(int n) { return std::uniform_int_distribution<int>(0, n - 1)(engine_); }
  Vec3 vec(double size) { return {in(-size, size), in(-size, size), in(-size, size)}; }
  Vec3 unit() {
    for (;;) {
      const Vec3 v = vec(1);
      if (norm(v) > 0.1 && norm(v) < 1) return v / norm(v);
    }
  }
  Pose pose(double size) {
    const Vec3 axis = unit();
    const Mat3 R = rotation_about(axis, in(-pi, pi));
    return {R, vec(size)};
  }
  /// A random shape. Each random value is drawn in a statement of its own, so that every compiler makes the same shapes.
  Shape shape(ShapeType type) {
    switch (type) {
      case ShapeType::sphere: {
        const double radius = in(0.05, 0.4);
        return Shape::sphere(radius, pose(0.2));
      }
      case ShapeType::capsule: {
        const Vec3 a = vec(0.3);
        const double radius = in(0.05, 0.3);
        const Vec3 along = unit();
        return Shape::capsule(radius, a, a + along * in(0.1, 1.0));
      }
      default: {
        const Vec3 half{in(0.05, 0.5), in(0.05, 0.5), in(0.05, 0.5)};
        return Shape::box(half, pose(0.2));
      }
    }
  }
  Shape shape() { return shape(static_cast<ShapeType>(below(3))); }

 private:
  std::mt19937_64 engine_;
};

/// Maximum of n . x over the shape, m.
inline double support(const Shape& s, const Pose& X_WB, const Vec3& n) {
  const Pose X = X_WB * s.X_BS;
  const Vec3 m = transpose_times(X.R, n);
  const double centre = dot(n, X.p);
  if (s.type == ShapeType::box)
    return centre + s.half_extents.x * std::fabs(m.x) + s.half_extents.y * std::fabs(m.y) + s.half_extents.z * std::fabs(m.z);
  return centre + s.radius + (s.type == ShapeType::capsule ? s.half_length * std::fabs(m.z) : 0.0);
}

/// Point of the solid shape nearest to p.
inline Vec3 project(const Shape& s, const Pose& X_WB, const Vec3& p) {
  const Pose X = X_WB * s.X_BS;
  Vec3 q = transpose_times(X.R, p - X.p);
  if (s.type == ShapeType::box) {
    for (int i = 0; i < 3; ++i) q[i] = std::clamp(q[i], -s.half_extents[i], s.half_extents[i]);
  } else {
    const double h = s.type == ShapeType::capsule ? s.half_length : 0.0;
    const Vec3 on_axis{0, 0, std::clamp(q.z, -h, h)};
    const Vec3 out = q - on_axis;
    if (norm(out) > s.radius) q = on_axis + out * (s.radius / norm(out));
  }
  return X * q;
}

/// Thickness [m] of the slab with normal n (from b towards a) between a and b; negative if they overlap along n.
inline double separation(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB, const Vec3& n) {
  return -support(a, X_WA, -n) - support(b, X_WB, n);
}

}  // namespace ugoki::collision::test
