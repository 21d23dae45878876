#pragma once
// A fan: a corner of the difference of two hulls with four edges that start at it, in SIMD lanes, for hull_leap.h. Computes the point of
// the fan's edges and faces that is closest to the origin.

#include "ugoki/collision/lane_simplex.h"

namespace ugoki::collision {
namespace {  // NOLINT(google-build-namespaces): see gilbert_search.h

/// Permutes lanes: the result consists of lanes i, j, k, l of x.
template <int i, int j, int k, int l, class T>
static inline T shuffle(const T& x) {
  return __builtin_shufflevector(x, x, i, j, k, l);
}
static inline Four lesser(const Four& a, const Four& b) { return b < a ? b : a; }
static inline Four greater(const Four& a, const Four& b) { return b > a ? b : a; }
static inline Four3 operator+(const Four3& a, const Four3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
static inline Four3 operator*(const Four3& a, const Four& s) { return {a.x * s, a.y * s, a.z * s}; }

/// True if any lane of the mask is set.
static inline bool any_of(const FourInts& mask) {
  const FourInts two = mask | shuffle<2, 3, 0, 1>(mask);
  return (two[0] | two[1]) != 0;
}

/// The lowest and the second lowest of eight values, in all lanes. Their lowest three bits are lane indices, as in lowest_with_lane().
struct TwoLowest {
  Four first, second;
};
static inline TwoLowest two_lowest_with_lanes(const Four& x, const Four& y) {
  const FourInts eight = all(~std::int64_t{7}), lanes = {0, 1, 2, 3}, more_lanes = {4, 5, 6, 7};
  const Four a = (Four)(((FourInts)x & eight) | lanes), b = (Four)(((FourInts)y & eight) | more_lanes);
  TwoLowest of{lesser(a, b), greater(a, b)};
  const auto join = [&](const Four& first, const Four& second) {
    of = {lesser(of.first, first), lesser(greater(of.first, first), lesser(of.second, second))};
  };
  join(shuffle<2, 3, 0, 1>(of.first), shuffle<2, 3, 0, 1>(of.second));
  join(shuffle<1, 0, 3, 2>(of.first), shuffle<1, 0, 3, 2>(of.second));
  return of;
}

#if defined(__AVX2__) && !defined(__AVX512VL__)
/// Each 64-bit lane of `named` has a lane index i in its lowest two bits. Returns 2 i and 2 i + 1, the indices of the 32-bit halves of
/// lane i, in the halves of that lane: AVX2 permutes 32-bit values only.
static inline __m256i halves_of(const Four& named) {
  const __m256i lanes = _mm256_and_si256(_mm256_shuffle_epi32((__m256i)named, 0xa0), _mm256_set1_epi32(3));
  return _mm256_add_epi32(_mm256_slli_epi32(lanes, 1), _mm256_set_epi32(1, 0, 1, 0, 1, 0, 1, 0));
}
#endif

/// Selects, for each lane, one of the eight lanes of x and y. Its index (0 ... 3 in x, 4 ... 7 in y) is in the lowest three bits of the
/// lane of `named`.
static inline Four pick(const Four& x, const Four& y, const Four& named) {
#if defined(__AVX512F__) && defined(__AVX512VL__)
  return (Four)_mm256_permutex2var_pd((__m256d)x, (__m256i)named, (__m256d)y);
#elif defined(__AVX2__)
  const __m256i halves = halves_of(named), third_bit_first = _mm256_slli_epi64((__m256i)named, 61);
  return (Four)_mm256_blendv_pd((__m256d)_mm256_permutevar8x32_ps((__m256)x, halves), (__m256d)_mm256_permutevar8x32_ps((__m256)y, halves),
                                (__m256d)third_bit_first);
#else
  const double both[8] = {x[0], x[1], x[2], x[3], y[0], y[1], y[2], y[3]};
  const FourInts i = (FourInts)named & all(std::int64_t{7});
  return Four{both[i[0]], both[i[1]], both[i[2]], both[i[3]]};
#endif
}
/// Copies one lane of x to all lanes. Its index is in the lowest two bits of `named`.
static inline Four take(const Four& x, const Four& named) {
#if defined(__AVX512F__) && defined(__AVX512VL__)
  return (Four)_mm256_permutexvar_pd((__m256i)named, (__m256d)x);
#elif defined(__AVX2__)
  return (Four)_mm256_permutevar8x32_ps((__m256)x, halves_of(named));
#else
  const double four[4] = {x[0], x[1], x[2], x[3]};
  return all(four[((FourInts)named)[0] & 3]);
#endif
}
static inline Four3 take(const Four3& x, const Four& named) { return {take(x.x, named), take(x.y, named), take(x.z, named)}; }

/// A corner p of the difference and four edges that start at it: edges of a in lanes 0 and 2, edges of b in lanes 1 and 3. The features are
/// the four edges and the four faces of the lane pairs (0, 1), (1, 3), (2, 0) and (3, 0). Edges of different hulls span a parallelogram,
/// edges of one hull a triangle.
struct LaneFan {
  Four named;  ///< lowest two bits: lane of the closest feature (of its first edge, if it is a face)
  Four s, t;   ///< per lane: coordinates 0 ... 1 of the closest point along the first and the second edge
  Four3 v;     ///< m: the point closest to the origin, the same in all lanes
  Four3 f;     ///< m: in each lane, the second edge of the lane's face

  /// Masks of the lanes whose first, or second, edge belongs to hull a.
  static constexpr FourInts first_of_a = {-1, 0, -1, 0}, second_of_a = {0, 0, -1, -1};

  /// @param e m: the four edges that start at p, one per lane
  /// @param p m: corner of the fan, the same in all lanes
  LaneFan(const Four3& e, const Four3& p) : f{seconds(e.x), seconds(e.y), seconds(e.z)} {
    const Four zero = all(0.0), one = all(1.0), far = all(1e300);
    const FourInts parallelogram = {-1, 0, 0, -1};
    const Four3 n = cross(e, f);
    const Four nn = dot(n, n), height = dot(n, p), ee = dot(e, e), ff = seconds(ee), ef = dot(e, f);
    const Four along = -dot(e, p), along_f = seconds(along);
    // ws, wt: coordinates of the projected origin along both edges of a face, times n . n. A face is skipped if the sine of the angle
    // between its edges is below 1e-14.
    const Four ws = along * ff - along_f * ef, wt = along_f * ee - along * ef, maximum = parallelogram ? greater(ws, wt) : ws + wt;
    const FourInts face_ok = (ws >= zero) & (wt >= zero) & (maximum <= nn) & (nn > 1e-28 * ee * ff);
    const Four scale = one / nn, face_vv = face_ok ? (height * height) * scale : far;
    const Four pp = dot(p, p);
    const FourInts before = along <= zero, past = along >= ee;
    Four u = along / ee;
    Four edge_vv = past ? pp - (along + (along - ee)) : pp - along * u;
    edge_vv = before ? pp : edge_vv;
    u = past ? one : u;
    u = before ? zero : u;
    const FourInts is_face = face_vv < edge_vv;
    const Four minimum = lesser(face_vv, edge_vv);
    named = (Four)(((FourInts)minimum & ~FourInts{3, 3, 3, 3}) | FourInts{0, 1, 2, 3});
    named = lesser(named, shuffle<2, 3, 0, 1>(named));
    named = lesser(named, shuffle<1, 0, 3, 2>(named));
    const Four sf = ws * scale, tf = wt * scale;
    s = is_face ? sf : u;
    t = is_face ? tf : zero;
    v = take(select(is_face, p + e * sf + f * tf, p + e * u), named);
  }
  /// Lane of the second edge of the face whose first edge is in `lane`.
  static int second_lane(int lane) { return lane == 0 ? 1 : lane == 1 ? 3 : 0; }
  /// Lane of the closest feature (of its first edge, if it is a face).
  [[nodiscard]] int lane() const { return static_cast<int>(((FourInts)named)[0] & 3); }

 private:
  /// Lane k of the result: the value of x for the second edge of the face in lane k.
  static Four seconds(const Four& x) { return shuffle<1, 3, 0, 0>(x); }
};

}  // namespace
}  // namespace ugoki::collision
