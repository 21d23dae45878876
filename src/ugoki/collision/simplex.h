#pragma once
// Points of a simplex nearest to the origin, for Gilbert's method: each case by the signs of its barycentric coordinates, each
// answer from differences of the corners, so that a small distance keeps its digits.
// Source: Montanari, Petrinic, Barbieri, Improving the GJK algorithm for faster and more reliable distance queries between convex
// objects (2017).

#include <cstdint>

#include "ugoki/spatial/vec3.h"

namespace ugoki::collision {

/// A point of the difference a - b of two shapes, and what it is made of.
struct Corner {
  Vec3 w, a;            ///< m, frame of a; w = a - b
  std::int32_t ia, ib;  ///< vertices of the two shapes
};

/// Up to four corners; after `reduce` those that span the nearest point, with their weights.
struct Simplex {
  Corner corner[4];
  double weight[4];
  int count = 0;
};

struct NearestPoint {
  Vec3 v;
  double weight[3];
};

inline double nearest_on_segment(const Vec3& p, const Vec3& q, Vec3& v) {
  const Vec3 e = q - p;
  const double along = -dot(p, e), length2 = dot(e, e);
  if (!(along > 0)) {
    v = p;
    return 0;
  }
  if (along >= length2) {
    v = q;
    return 1;
  }
  const double t = along / length2;
  v = p + e * t;
  v -= e * (dot(v, e) / length2);  // square on the edge, also where v is short
  return t;
}

inline void keep_nearer(NearestPoint& best, double& best_vv, const Vec3& v, double wp, double wq, double wr) {
  const double vv = dot(v, v);
  if (vv < best_vv) {
    best_vv = vv;
    best = {v, {wp, wq, wr}};
  }
}

/// On the triangle p, p + e, p + f with n = e x f. Keeps `best` where that is nearer.
inline void nearest_on_triangle(const Vec3& p, const Vec3& e, const Vec3& f, const Vec3& n, NearestPoint& best, double& best_vv) {
  const double nn = dot(n, n);
  const Vec3 m = cross(n, p);
  const double wr = dot(e, m), wq = -dot(f, m), wp = nn - wq - wr;
  const bool flat = !(nn > 1e-28 * dot(e, e) * dot(f, f));
  if (!flat && wp >= 0 && wq >= 0 && wr >= 0) {
    const double s = 1 / nn;
    keep_nearer(best, best_vv, n * (dot(n, p) * s), wp * s, wq * s, wr * s);
    return;
  }
  Vec3 v;
  const Vec3 q = p + e, r = p + f;
  if (flat || wr < 0) {
    const double t = nearest_on_segment(p, q, v);
    keep_nearer(best, best_vv, v, 1 - t, t, 0);
  }
  if (flat || wq < 0) {
    const double t = nearest_on_segment(p, r, v);
    keep_nearer(best, best_vv, v, 1 - t, 0, t);
  }
  if (flat || wp < 0) {
    const double t = nearest_on_segment(q, r, v);
    keep_nearer(best, best_vv, v, 0, 1 - t, t);
  }
}

/// Reduces the simplex to the corners that span its point nearest to the origin, which is returned.
/// @param noise length below which the origin's distance from a plane is not known
/// @param inside [out] the origin lies in the tetrahedron
inline Vec3 reduce(Simplex& s, double noise, bool& inside) {
  inside = false;
  double best_vv = 1e300;
  NearestPoint best{};
  int from[3] = {0, 1, 2};
  if (s.count == 1) {
    s.weight[0] = 1;
    return s.corner[0].w;
  }
  if (s.count == 2) {
    const double t = nearest_on_segment(s.corner[0].w, s.corner[1].w, best.v);
    best.weight[0] = 1 - t;
    best.weight[1] = t;
  } else if (s.count == 3) {
    const Vec3 &p = s.corner[2].w, e = s.corner[0].w - p, f = s.corner[1].w - p;
    nearest_on_triangle(p, e, f, cross(e, f), best, best_vv);
    from[0] = 2, from[1] = 0, from[2] = 1;
  } else {
    // The newest corner is the last; the origin is known to be on its side of the other three.
    const Vec3& p = s.corner[3].w;
    const Vec3 e[3] = {s.corner[0].w - p, s.corner[1].w - p, s.corner[2].w - p};
    const Vec3 n[3] = {cross(e[0], e[1]), cross(e[1], e[2]), cross(e[2], e[0])};
    const double volume = dot(n[0], e[2]);
    bool out[3];
    bool any = false;
    for (int k = 0; k < 3; ++k) {
      const double height = dot(n[k], p);
      out[k] = height * volume >= 0 || height * height <= noise * noise * dot(n[k], n[k]);
      any = any || out[k];
    }
    if (!any) {
      inside = true;
      s.weight[3] = 1;
      for (int k = 0; k < 3; ++k) {
        const int opposite = k == 0 ? 2 : k - 1;
        s.weight[opposite] = -dot(n[k], p) / volume;
        s.weight[3] -= s.weight[opposite];
      }
      return {};
    }
    int face = 0;
    for (int k = 0; k < 3; ++k)
      if (out[k]) {
        const double before = best_vv;
        nearest_on_triangle(p, e[k], e[k == 2 ? 0 : k + 1], n[k], best, best_vv);
        if (best_vv < before) face = k;
      }
    from[0] = 3, from[1] = face, from[2] = face == 2 ? 0 : face + 1;
  }
  Corner kept[3];
  int count = 0;
  for (int k = 0; k < (s.count == 2 ? 2 : 3); ++k)
    if (best.weight[k] > 0) {
      s.weight[count] = best.weight[k];
      kept[count++] = s.corner[from[k]];
    }
  for (int k = 0; k < count; ++k) s.corner[k] = kept[k];
  s.count = count;
  return best.v;
}

}  // namespace ugoki::collision
