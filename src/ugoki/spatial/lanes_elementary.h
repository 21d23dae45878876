#pragma once
// Sine and cosine in lanes. In double the bits of every lane are those of sin_cos() in elementary.h.

#include "ugoki/spatial/lanes.h"

namespace ugoki {
namespace {  // NOLINT(google-build-namespaces): see lanes.h

template <class T>
struct LaneSinCos {
  T sin, cos;
};

template <class T>
using LaneBits = std::conditional_t<sizeof(typename T::Real) == 8, std::int64_t, std::int32_t>;

/// Greatest integers not above; |x| < 2^51 (double), 2^22 (float).
template <class T>
T lane_floor(T x) {
  using Real = typename T::Real;
  constexpr Real magic = sizeof(Real) == 8 ? Real(0x1.8p52) : Real(0x1.8p23);
  const T nearest = (x + T(magic)) - T(magic);
  return nearest - select(nearest > x, T(Real(1)), T(Real(0)));
}

/// sin and cos of r + n pi/2 from those of r: swapped and negated by the two lowest bits of n.
template <class T>
LaneSinCos<T> turn_by_quarters(T n, T s, T c) {
  using Real = typename T::Real;
  using Int = LaneBits<T>;
  constexpr Real magic = sizeof(Real) == 8 ? Real(0x1.8p52) : Real(0x1.8p23);
  constexpr int top = 8 * int{sizeof(Real)} - 2;
  const T shifted = n + T(magic);
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

/// Of doubles. The steps are those of sin_cos() in elementary.cpp, one for one.
template <int N>
LaneSinCos<Lanes<double, N>> lane_sin_cos(Lanes<double, N> x) {
  using T = Lanes<double, N>;
  const T n = lane_floor(x * T(2.0 / 3.14159265358979323846) + T(0.5));
  T head = (x - n * T(0x1.921fb544p+0)) - n * T(0x1.0b4611a6p-34);
  T small = n * T(0x1.3198a2e037073p-69);
  T smaller(0.0);
  const auto far = (!(n < T(0x1p20))) | (!(n > T(-0x1p20)));
  if (any(far)) {
    head = select(far, (x - n * T(0x1.921fb54000000p+0)) - n * T(0x1.10b4600000000p-30), head);
    small = select(far, n * T(0x1.1a62630000000p-54), small);
    smaller = select(far, n * T(0x1.8a2e03707344ap-81), smaller);
  }
  const T r = head - small;
  const T taken = head - r;
  const T tail = ((head - (r + taken)) + (taken - small)) - smaller;

  const T z = r * r;
  T s(1.0 / 355687428096000.0);
  s = s * z - T(1.0 / 1307674368000.0);
  s = s * z + T(1.0 / 6227020800.0);
  s = s * z - T(1.0 / 39916800.0);
  s = s * z + T(1.0 / 362880.0);
  s = s * z - T(1.0 / 5040.0);
  s = s * z + T(1.0 / 120.0);
  s = s * z - T(1.0 / 6.0);
  const T sine = r + (r * (z * s) + tail);
  T c(1.0 / 20922789888000.0);
  c = c * z - T(1.0 / 87178291200.0);
  c = c * z + T(1.0 / 479001600.0);
  c = c * z - T(1.0 / 3628800.0);
  c = c * z + T(1.0 / 40320.0);
  c = c * z - T(1.0 / 720.0);
  c = c * z + T(1.0 / 24.0);
  const T half = T(0.5) * z;
  const T cap = T(1.0) - half;
  const T cosine = cap + (((T(1.0) - cap) - half) + (z * z * c - r * tail));

  const LaneSinCos<T> out = turn_by_quarters(n, sine, cosine);
  const auto outside = (!(x > T(-1e8))) | (!(x < T(1e8)));
  const T nan(__builtin_nan(""));
  return {select(outside, nan, out.sin), select(outside, nan, out.cos)};
}

/// Of floats: errors below 2 units in the last place of 1 for |x| < 10^4 rad; NaN from 10^5 on.
template <int N>
LaneSinCos<Lanes<float, N>> lane_sin_cos(Lanes<float, N> x) {
  using T = Lanes<float, N>;
  const T n = lane_floor(x * T(0.636619772f) + T(0.5f));
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
  const LaneSinCos<T> out = turn_by_quarters(n, sine, cosine);
  const auto outside = (!(x > T(-1e5f))) | (!(x < T(1e5f)));
  const T nan(__builtin_nanf(""));
  return {select(outside, nan, out.sin), select(outside, nan, out.cos)};
}

}  // namespace
}  // namespace ugoki
