#pragma once
// Meshes shared by the tests of sphere trees and mesh distances.

#include <cmath>
#include <vector>

#include "random_shapes.h"
#include "ugoki/mechanism/geometry.h"

namespace ugoki::collision::test {

struct Mesh {
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
};

/// A closed tube of about n triangles, the surface f(u, v): u runs along the tube, v around it, both with the period 2 pi.
template <class F>
Mesh make_tube(int n, F f) {
  const int around = std::max(3, static_cast<int>(std::sqrt(n / 8.0))), along = std::max(3, n / 2 / around);
  Mesh out;
  for (int i = 0; i < along; ++i)
    for (int j = 0; j < around; ++j) out.vertices.push_back(f(2 * pi * i / along, 2 * pi * j / around));
  for (int i = 0; i < along; ++i)
    for (int j = 0; j < around; ++j) {
      const int i1 = (i + 1) % along, j1 = (j + 1) % around;
      const int a = i * around + j, b = i1 * around + j, c = i1 * around + j1, d = i * around + j1;
      out.triangles.push_back({a, b, c});
      out.triangles.push_back({a, c, d});
    }
  return out;
}

/// A torus of radius 1 (to the middle of the tube) with a tube of radius about 0.4.
inline Mesh bumpy_torus(int n) {
  return make_tube(n, [](double u, double v) {
    const double r = 0.4 * (1 + 0.08 * sin(7 * u) * sin(5 * v)), out = 1 + r * cos(v);
    return Vec3{out * cos(u), out * sin(u), r * sin(v)};
  });
}

/// A trefoil knot that fits through the hole of bumpy_torus().
inline Mesh torus_knot(int n) {
  const auto middle = [](double t) {
    const double q = 0.1 * (2 + cos(3 * t));
    return Vec3{q * cos(2 * t), q * sin(2 * t), 0.3 * sin(3 * t)};
  };
  return make_tube(n, [&](double u, double v) {
    const Vec3 along = normalized(middle(u + 1e-4) - middle(u - 1e-4)), a = normalized(cross(along, Vec3{0, 0, 1})), b = cross(along, a);
    const double r = 0.08 * (1 + 0.1 * sin(11 * u) * sin(3 * v));
    return middle(u) + a * (r * cos(v)) + b * (r * sin(v));
  });
}

/// n random triangles within `size` of the origin; a quarter of them are needles.
inline Mesh soup(Random& random, int n, double size) {
  Mesh out;
  for (int i = 0; i < n; ++i) {
    const Vec3 p = random.vec(size), a = random.unit() * (size * random.in(0.01, 0.4));
    const Vec3 b =
        random.below(4) == 0 ? a * random.in(-1, 1) + random.unit() * (size * 1e-6) : random.unit() * (size * random.in(0.01, 0.4));
    const auto first = static_cast<std::int32_t>(out.vertices.size());
    out.vertices.insert(out.vertices.end(), {p, p + a, p + b});
    out.triangles.push_back({first, first + 1, first + 2});
  }
  return out;
}

inline Mesh box_mesh(const Vec3& half) {
  Mesh out;
  for (int i = 0; i < 8; ++i) out.vertices.push_back({(i & 1 ? 1 : -1) * half.x, (i & 2 ? 1 : -1) * half.y, (i & 4 ? 1 : -1) * half.z});
  out.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                   {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return out;
}

inline Mesh scaled(Mesh m, double by, const Vec3& moved = {}) {
  for (Vec3& v : m.vertices) v = v * by + moved;
  return m;
}

}  // namespace ugoki::collision::test
