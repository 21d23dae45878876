#pragma once
// The simplex of Gilbert's method in SIMD lanes, for hull_search.h. It computes the same as `reduce` in simplex.h, without branches. It is
// less accurate for slivers and for points close to the origin; the duality gap then stays too large, and the general search is used.

#include <cstdint>

#include "ugoki/collision/hull_walk.h"
#include "ugoki/collision/lanes_of_four.h"

#ifdef __AVX2__
#include <immintrin.h>
#endif

namespace ugoki::collision {
namespace {  // NOLINT(google-build-namespaces): see gilbert_search.h

/// Copies a value to all lanes.
static inline Four all(double x) { return Four{x, x, x, x}; }
static inline FourInts all(std::int64_t x) { return FourInts{x, x, x, x}; }
static inline Four four_at(const double* p) {
  Four x;
  __builtin_memcpy(&x, p, sizeof x);
  return x;
}

/// Four 3-vectors, one per lane.
template <class T>
struct Lanes3 {
  T x, y, z;
};
using Four3 = Lanes3<Four>;

template <class T>
static inline T dot(const Lanes3<T>& a, const Lanes3<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
static inline Four3 cross(const Four3& a, const Four3& b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
static inline Four3 operator-(const Four3& a, const Four3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
static inline Four3 select(const FourInts& m, const Four3& a, const Four3& b) { return {m ? a.x : b.x, m ? a.y : b.y, m ? a.z : b.z}; }
static inline Four3 all(const Vec3& v) { return {all(v.x), all(v.y), all(v.z)}; }
/// Vector with coordinates x, y, z = lanes 0, 1, 2 of the argument, each copied to all lanes.
static inline Four3 spread(const Four& x) {
  return {__builtin_shufflevector(x, x, 0, 0, 0, 0), __builtin_shufflevector(x, x, 1, 1, 1, 1), __builtin_shufflevector(x, x, 2, 2, 2, 2)};
}
/// next, after_next: lane k receives lane k + 1, or k + 2, cyclically among lanes 0 to 2; lane 3 is unchanged.
template <class T>
static inline T next(const T& x) {
  return __builtin_shufflevector(x, x, 1, 2, 0, 3);
}
template <class T>
static inline T after_next(const T& x) {
  return __builtin_shufflevector(x, x, 2, 0, 1, 3);
}

/// The minimum of eight values, in all lanes. Its lowest three mantissa bits are replaced by its lane index (0 ... 3 in x, 4 ... 7 in y).
static inline Four lowest_with_lane(const Four& x, const Four& y) {
  const FourInts eight = all(~std::int64_t{7}), lanes = {0, 1, 2, 3}, more_lanes = {4, 5, 6, 7};
  const Four a = (Four)(((FourInts)x & eight) | lanes), b = (Four)(((FourInts)y & eight) | more_lanes), four = b < a ? b : a;
  const Four c = __builtin_shufflevector(four, four, 2, 3, 0, 1), two = c < four ? c : four;
  const Four d = __builtin_shufflevector(two, two, 1, 0, 3, 2), one = d < two ? d : two;
  return __builtin_shufflevector(one, one, 0, 0, 0, 0);
}
/// The lane index in the result of lowest_with_lane().
static inline int lane_in(const Four& named) { return static_cast<int>(((FourInts)named)[0] & 7); }
/// Copies one of the eight lanes of x and y to all lanes; lane_in(named) is its index.
static inline Four lane_of(const Four& x, const Four& y, const Four& named) {
#if defined(__AVX512F__) && defined(__AVX512VL__)
  return (Four)_mm256_permutex2var_pd((__m256d)x, (__m256i)named, (__m256d)y);
#else
  const double both[8] = {x[0], x[1], x[2], x[3], y[0], y[1], y[2], y[3]};
  return all(both[lane_in(named)]);
#endif
}

/// A simplex of up to three corners (lanes 0 ... 2) and its point closest to the origin.
struct LaneSimplex {
  Four3 w;                 ///< m: corners of the difference a - b
  FourInts ia, ib, alive;  ///< ia, ib: vertices of a and b at each corner; alive: mask of the corners in use
  Four weight;             ///< barycentric weights: v is the weighted sum of the corners
  Four3 v;                 ///< m: the point closest to the origin, the same in all lanes

  /// Adds the corner p (vertices pa, pb) and reduces the simplex to the feature that contains its point closest to the origin. Only
  /// features that contain p are tested, as the simplex without p was reduced before. A feature has at most two other corners, so one lane
  /// is left for p. The tetrahedron's interior is not tested.
  void add(const Four3& p, std::int32_t pa, std::int32_t pb) {
    const Four zero = all(0.0), one = all(1.0), far = all(1e300);
    const Four3 e = w - p, f{next(e.x), next(e.y), next(e.z)}, n = cross(e, f);
    const Four nn = dot(n, n), height = dot(n, p), ee = dot(e, e), ff = next(ee), ef = dot(e, f), pp = dot(p, p);
    const Four along = -dot(e, p), along_f = next(along);
    // Faces of p and the corners k and k + 1: barycentric weights times n . n. A face is skipped if the sine of the angle between its edges
    // is below 1e-14.
    const Four wq = along * ff - along_f * ef, wr = along_f * ee - along * ef, wp = nn - wq - wr;
    const FourInts face_ok = alive & next(alive) & (wp >= zero) & (wq >= zero) & (wr >= zero) & (nn > 1e-28 * ee * ff);
    const Four scale = one / nn, hs = height * scale, face_vv = face_ok ? height * hs : far;
    // Edges from p to corner k.
    Four t = along / ee;
    t = t > zero ? t : zero;
    t = alive ? (t < one ? t : one) : zero;
    const Four edge_vv = pp - t * (along + (along - t * ee));
    const FourInts is_face = face_vv < edge_vv;
    const Four minimum = is_face ? face_vv : edge_vv;
    const Four3 point{is_face ? n.x * hs : p.x + e.x * t, is_face ? n.y * hs : p.y + e.y * t, is_face ? n.z * hs : p.z + e.z * t};
    // Select the closest of the three features; the lane index in the last bits makes the minimum unique. best, second: masks of the old
    // corners that the closest feature keeps; newest: mask of the lane that receives p.
    const Four named = (Four)(((FourInts)minimum & ~FourInts{3, 3, 3, 3}) | FourInts{0, 1, 2, 3});
    const FourInts best = (named < next(named)) & (named < after_next(named));
    const FourInts second = after_next(best & is_face), newest = next(best);
    const Four own = is_face ? wq * scale : t, rest = next(is_face ? wp * scale : one - t);
    weight = best ? own : zero;
    weight = second ? after_next(wr * scale) : weight;
    weight = newest ? rest : weight;
    alive = (best | second | newest) & (weight > zero);
    w = select(newest, p, w);
    ia = newest ? all(std::int64_t{pa}) : ia;
    ib = newest ? all(std::int64_t{pb}) : ib;
    v = {of(best, point.x), of(best, point.y), of(best, point.z)};
  }

 private:
  /// Copies the value of the single lane that is set in the mask to all lanes.
  static Four of(const FourInts& mask, const Four& x) {
    const FourInts one = mask & (FourInts)x, two = one | __builtin_shufflevector(one, one, 1, 0, 3, 2);
    return (Four)(two | __builtin_shufflevector(two, two, 2, 3, 0, 1));
  }
};

}  // namespace
}  // namespace ugoki::collision
