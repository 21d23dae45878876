#pragma once
// Distances between two triangles in SIMD lanes, one pair per lane: the template behind triangle_distance.h and the leaves of bubble.h.
// Internal to collision/.
//
// Every candidate distance is computed from two points on the triangles, so that its error is a few units in the last place. The code has a
// single branch: it skips the piercing test if no lane can pierce.

#include "ugoki/spatial/lanes.h"
#include "ugoki/spatial/vec3.h"

namespace ugoki::collision {
namespace {

/// Squared distance d2 [m^2], and the closest points a and b [m] (set only if with_points).
template <class T>
struct ClosestPoints {
  T d2;
  Vec3T<T> a, b;
};

template <class T>
T minimum(T a, T b) {
  return select(a < b, a, b);
}
template <class T>
T maximum(T a, T b) {
  return select(a > b, a, b);
}
/// x clamped to 0 ... 1; NaN becomes 0.
template <class T>
T cut(T x) {
  return minimum(maximum(x, T(0)), T(1));
}
template <class Mask>
Mask both(Mask a, Mask b) {
  const Mask not_a = !a, not_b = !b;
  return !(not_a | not_b);
}
template <class T>
Vec3T<T> select(typename T::Mask m, const Vec3T<T>& a, const Vec3T<T>& b) {
  return {select(m, a.x, b.x), select(m, a.y, b.y), select(m, a.z, b.z)};
}

/// A triangle, prepared for the projection of points on its plane p + x c + y g. c is the side from corner 0 to 1; g, perpendicular to c,
/// is the height to corner 2. If c is the longest side, needles and caps lose no accuracy.
template <class T>
struct Face {
  Vec3T<T> p, c, g;
  T per_c2, per_g2, slant;

  explicit Face(const Vec3T<T>* corner) : p(corner[0]), c(corner[1] - corner[0]) {
    const Vec3T<T> b = corner[2] - corner[0];
    per_c2 = T(1) / dot(c, c);
    slant = dot(b, c) * per_c2;
    g = b - c * slant;
    per_g2 = T(1) / dot(g, g);
  }
};

/// Projection of a point on the plane of a face.
template <class T>
struct Foot {
  Vec3T<T> up;  // m: from the foot (the projected point) to the point
  T w1, w2;     // barycentric coordinates of the foot for corners 1 and 2

  Foot() = default;
  Foot(const Face<T>& f, const Vec3T<T>& q) {
    const Vec3T<T> r = q - f.p;
    const T x = dot(r, f.c) * f.per_c2;
    const Vec3T<T> across = r - f.c * x;
    w2 = dot(across, f.g) * f.per_g2;
    w1 = x - w2 * f.slant;
    up = across - f.g * w2;
  }
  /// Mask of the lanes whose foot is in the triangle.
  [[nodiscard]] typename T::Mask inside() const { return !((w1 < T(0)) | (w2 < T(0)) | (w1 + w2 > T(1))); }
};

/// Tests triangle q against face f of the other triangle, and updates `best`: corners of q above the face, and sides of q that pierce it.
/// @tparam swapped true: f is the face of triangle b
template <bool with_points, bool swapped, class T>
void try_face(const Face<T>& f, const Vec3T<T>* q, ClosestPoints<T>& best) {
  Foot<T> feet[3];
  const auto take = [&](typename T::Mask better, T d2, const Vec3T<T>& x, const Foot<T>& foot) {
    best.d2 = select(better, d2, best.d2);
    if constexpr (with_points) {
      const Vec3T<T> on_face = x - foot.up;
      best.a = select<T>(better, swapped ? x : on_face, best.a);
      best.b = select<T>(better, swapped ? on_face : x, best.b);
    }
  };
  for (int k = 0; k < 3; ++k) {
    feet[k] = Foot<T>(f, q[k]);
    const T d2 = dot(feet[k].up, feet[k].up);
    take(both(feet[k].inside(), d2 < best.d2), d2, q[k], feet[k]);
  }
  const T turn[3] = {dot(feet[0].up, feet[1].up), dot(feet[1].up, feet[2].up), dot(feet[2].up, feet[0].up)};
  if (!any((turn[0] < T(0)) | (turn[1] < T(0)) | (turn[2] < T(0)))) return;
  for (int k = 0; k < 3; ++k) {
    const Foot<T>&from = feet[k], &to = feet[k == 2 ? 0 : k + 1];
    const Vec3T<T> climb = to.up - from.up;
    const T s = -dot(from.up, climb) / dot(climb, climb);
    Foot<T> through;
    through.up = {T(0), T(0), T(0)};
    through.w1 = from.w1 + s * (to.w1 - from.w1);
    through.w2 = from.w2 + s * (to.w2 - from.w2);
    const typename T::Mask pierces = both(both(turn[k] < T(0), through.inside()), best.d2 > T(0));
    take(pierces, T(0), q[k] + (q[k == 2 ? 0 : k + 1] - q[k]) * s, through);
  }
}

/// Tests all nine pairs of sides of the triangles p and q, and updates `best`. Source: Ericson (2005), 5.1.9.
template <bool with_points, class T>
void try_sides(const Vec3T<T>* p, const Vec3T<T>* q, ClosestPoints<T>& best) {
  Vec3T<T> f[3];
  T per_f2[3];
  for (int j = 0; j < 3; ++j) {
    f[j] = q[j == 2 ? 0 : j + 1] - q[j];
    per_f2[j] = T(1) / dot(f[j], f[j]);
  }
  for (int i = 0; i < 3; ++i) {
    const Vec3T<T> e = p[i == 2 ? 0 : i + 1] - p[i];
    const T per_e2 = T(1) / dot(e, e);
    for (int j = 0; j < 3; ++j) {
      const Vec3T<T> w = q[j] - p[i], n = cross(e, f[j]);
      const T ef = dot(e, f[j]);
      T s = cut(dot(cross(w, f[j]), n) / dot(n, n));
      const T t = cut((s * ef - dot(w, f[j])) * per_f2[j]);
      s = cut((dot(w, e) + t * ef) * per_e2);
      const Vec3T<T> apart = w + f[j] * t - e * s;
      const T d2 = dot(apart, apart);
      const typename T::Mask better = d2 < best.d2;
      best.d2 = select(better, d2, best.d2);
      if constexpr (with_points) {
        best.a = select<T>(better, p[i] + e * s, best.a);
        best.b = select<T>(better, q[j] + f[j] * t, best.b);
      }
    }
  }
}

/// Closest points of the triangles p and q (three corners each; the side from corner 0 to 1 is the longest). d2 is 0 if the triangles
/// pierce each other, and `above` if their squared distance is not below `above`.
template <bool with_points, class T>
ClosestPoints<T> closest_points(const Vec3T<T>* p, const Vec3T<T>* q, T above) {
  ClosestPoints<T> best{above, p[0], q[0]};
  try_sides<with_points>(p, q, best);
  try_face<with_points, false>(Face<T>(p), q, best);
  try_face<with_points, true>(Face<T>(q), p, best);
  return best;
}

}  // namespace
}  // namespace ugoki::collision
