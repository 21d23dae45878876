#pragma once
// Sine and cosine in SIMD lanes. For double, every lane has the same bits as sin_cos() in elementary.h.

#include "ugoki/spatial/lanes.h"

namespace ugoki {
namespace {  // NOLINT(google-build-namespaces): see lanes.h

template <class T>
struct LaneSinCos {
  T sin, cos;
};

template <class T>
using LaneBits = std::conditional_t<sizeof(typename T::Real) == 8, std::int64_t, std::int32_t>;

/// Rounding constant: x + rounding - rounding is x rounded to an integer n, and the low bits of x + rounding are those of n.
/// Valid for |x| < 2^51 (double) or 2^22 (float).
template <class T>
constexpr typename T::Real rounding = sizeof(typename T::Real) == 8 ? typename T::Real(0x1.8p52) : typename T::Real(0x1.8p23);

/// Sine and cosine of r + n pi/2 from s = sin(r) and c = cos(r): swaps and negates s and c according to the two lowest bits of n.
/// @param shifted n + rounding
template <class T>
LaneSinCos<T> turn_by_quarters(T shifted, T s, T c) {
  using Real = typename T::Real;
  using Int = LaneBits<T>;
  constexpr int top = 8 * int{sizeof(Real)} - 2;
  if constexpr (T::count == 1) {
    const Int k = __builtin_bit_cast(Int, shifted.v);
    const Real a = (k & 1) != 0 ? c.v : s.v, b = (k & 1) != 0 ? s.v : c.v;
    return {(k & 2) != 0 ? -a : a, ((k + 1) & 2) != 0 ? -b : b};
  } else {
    using Ints = typename T::Mask::Vector;
    const Ints k = __builtin_bit_cast(Ints, shifted.v);
    const Ints odd = (k & 1) != 0;
    const Ints a = __builtin_bit_cast(Ints, odd ? c.v : s.v), b = __builtin_bit_cast(Ints, odd ? s.v : c.v);
    using Vector = typename T::Vector;
    return {T::of(__builtin_bit_cast(Vector, a ^ ((k & 2) << top))), T::of(__builtin_bit_cast(Vector, b ^ (((k + 1) & 2) << top)))};
  }
}

/// Sine and cosine of doubles [rad]. Performs exactly the operations of sin_cos() in elementary.cpp, in the same order.
template <int N>
LaneSinCos<Lanes<double, N>> lane_sin_cos(Lanes<double, N> x) {
  using T = Lanes<double, N>;
  const T shifted = x * T(2.0 / 3.14159265358979323846) + T(rounding<T>), n = shifted - T(rounding<T>);
  T head = (x - n * T(0x1.921fb544p+0)) - n * T(0x1.0b4611a6p-34);
  T small = n * T(0x1.3198a2e037073p-69);
  T smaller(0.0);
  const auto far = !(n * n < T(0x1p40));
  const bool any_far = any(far);
  if (any_far) {
    head = select(far, (x - n * T(0x1.921fb54000000p+0)) - n * T(0x1.10b4600000000p-30), head);
    small = select(far, n * T(0x1.1a62630000000p-54), small);
    smaller = select(far, n * T(0x1.8a2e03707344ap-81), smaller);
  }
  const T r = head - small;
  T tail = (head - r) - small;
  if (any_far) tail -= smaller;

  const T z = r * r;
  T s(0x1.5d932f161657ap-33);
  s = s * z - T(0x1.ae5e66d444051p-26);
  s = s * z + T(0x1.71de357873a88p-19);
  s = s * z - T(0x1.a01a019c126a5p-13);
  s = s * z + T(0x1.111111110f881p-7);
  s = s * z - T(0x1.5555555555549p-3);
  const T sine = r + (r * (z * s) + tail);
  T c(-0x1.8faecefbf270ep-37);
  c = c * z + T(0x1.1ee9ec474fb94p-29);
  c = c * z - T(0x1.27e4f80a75c69p-22);
  c = c * z + T(0x1.a01a019cb26e2p-16);
  c = c * z - T(0x1.6c16c16c15184p-10);
  c = c * z + T(0x1.555555555554cp-5);
  const T cosine = T(1.0) - (T(0.5) * z - (z * z * c - r * tail));

  const LaneSinCos<T> out = turn_by_quarters(shifted, sine, cosine);
  if (!any_far) return out;
  const auto outside = (!(x > T(-1e8))) | (!(x < T(1e8)));
  const T nan(__builtin_nan(""));
  return {select(outside, nan, out.sin), select(outside, nan, out.cos)};
}

/// Sine and cosine of floats [rad]. Absolute error below 1.2e-7 (one unit in the last place of 1) for |x| < 10^4; NaN from 10^5 on.
template <int N>
LaneSinCos<Lanes<float, N>> lane_sin_cos(Lanes<float, N> x) {
  using T = Lanes<float, N>;
  const T shifted = x * T(0.636619772f) + T(rounding<T>), n = shifted - T(rounding<T>);
  const T r = ((x - n * T(1.5703125f)) - n * T(4.837512969970703125e-4f)) - n * T(7.549789948768648e-8f);
  const T z = r * r;
  T s(1.0f / 362880.0f);
  s = s * z - T(1.0f / 5040.0f);
  s = s * z + T(1.0f / 120.0f);
  s = s * z - T(1.0f / 6.0f);
  const T sine = r + r * (z * s);
  T c(-1.0f / 3628800.0f);
  c = c * z + T(1.0f / 40320.0f);
  c = c * z - T(1.0f / 720.0f);
  c = c * z + T(1.0f / 24.0f);
  const T cosine = (T(1.0f) - T(0.5f) * z) + z * z * c;
  const LaneSinCos<T> out = turn_by_quarters(shifted, sine, cosine);
  const auto outside = !(x * x < T(1e10f));
  if (!any(outside)) return out;
  const T nan(__builtin_nanf(""));
  return {select(outside, nan, out.sin), select(outside, nan, out.cos)};
}

}  // namespace
}  // namespace ugoki
