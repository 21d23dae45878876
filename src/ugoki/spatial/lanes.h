#pragma once
// SIMD lanes: N values with the interface of one scalar. Each operator acts lane by lane. The templates of vec3.h and spatial.h accept the
// type as their scalar type. N is a power of two; N = 1 is a plain scalar.
//
// For translation units of kernels only. The type has internal linkage ON PURPOSE: a kernel unit may be compiled for wider registers
// than other units, and the linker must not merge functions of such units. Kernel units may include only headers that are templates
// on the scalar, and must define no weak symbols (tests/dynamics/kernel_symbols.cmake).

#include <cstdint>
#include <type_traits>

#include "ugoki/spatial/lane_array.h"

namespace ugoki {
namespace {  // NOLINT(google-build-namespaces): see above

template <class Real, int N>
struct Lanes;

/// Result of a comparison: in each lane all bits are set (true) or none (false).
template <class Real, int N>
struct LaneMask {
  using Int = std::conditional_t<sizeof(Real) == 8, std::int64_t, std::int32_t>;
  typedef Int Vector __attribute__((vector_size(N * sizeof(Int))));
  Vector m;
  friend LaneMask operator|(LaneMask a, LaneMask b) { return {a.m | b.m}; }
  friend LaneMask operator!(LaneMask a) { return {~a.m}; }
  [[nodiscard]] bool operator[](int i) const { return m[i] != 0; }
};
template <class Real>
struct LaneMask<Real, 1> {
  bool m;
  friend LaneMask operator|(LaneMask a, LaneMask b) { return {a.m || b.m}; }
  friend LaneMask operator!(LaneMask a) { return {!a.m}; }
  [[nodiscard]] bool operator[](int) const { return m; }
};

template <class R, int N>
struct Lanes {
  using Real = R;
  using Mask = LaneMask<Real, N>;
  static constexpr int count = N;
  typedef Real Vector __attribute__((vector_size(N * sizeof(Real))));
  Vector v;

  Lanes() = default;
  Lanes(Real s) : v(s - Vector{}) {}  // copies s to all lanes; s - 0 equals s, including the sign of zero
  explicit Lanes(const LaneArray<Real, N>& x) { __builtin_memcpy(&v, x.x, sizeof v); }
  static Lanes of(const Vector& x) {
    Lanes out;
    out.v = x;
    return out;
  }
  static Lanes load(const Real* p) {
    Lanes x;
    __builtin_memcpy(&x.v, p, sizeof x.v);
    return x;
  }
  void store(Real* p) const { __builtin_memcpy(p, &v, sizeof v); }

  friend Lanes operator+(Lanes a, Lanes b) { return of(a.v + b.v); }
  friend Lanes operator-(Lanes a, Lanes b) { return of(a.v - b.v); }
  friend Lanes operator*(Lanes a, Lanes b) { return of(a.v * b.v); }
  friend Lanes operator/(Lanes a, Lanes b) { return of(a.v / b.v); }
  friend Lanes operator-(Lanes a) { return of(-a.v); }
  Lanes& operator+=(Lanes b) { return *this = *this + b; }
  Lanes& operator-=(Lanes b) { return *this = *this - b; }
  Lanes& operator*=(Lanes b) { return *this = *this * b; }
  friend Mask operator>(Lanes a, Lanes b) { return {a.v > b.v}; }
  friend Mask operator<(Lanes a, Lanes b) { return {a.v < b.v}; }
};

template <class R>
struct Lanes<R, 1> {
  using Real = R;
  using Mask = LaneMask<Real, 1>;
  static constexpr int count = 1;
  Real v;

  Lanes() = default;
  Lanes(Real s) : v(s) {}
  static Lanes load(const Real* p) { return *p; }
  void store(Real* p) const { *p = v; }

  friend Lanes operator+(Lanes a, Lanes b) { return a.v + b.v; }
  friend Lanes operator-(Lanes a, Lanes b) { return a.v - b.v; }
  friend Lanes operator*(Lanes a, Lanes b) { return a.v * b.v; }
  friend Lanes operator/(Lanes a, Lanes b) { return a.v / b.v; }
  friend Lanes operator-(Lanes a) { return -a.v; }
  Lanes& operator+=(Lanes b) { return *this = *this + b; }
  Lanes& operator-=(Lanes b) { return *this = *this - b; }
  Lanes& operator*=(Lanes b) { return *this = *this * b; }
  friend Mask operator>(Lanes a, Lanes b) { return {a.v > b.v}; }
  friend Mask operator<(Lanes a, Lanes b) { return {a.v < b.v}; }
};

/// Returns in each lane the value of a if the mask is set there, else the value of b.
template <class Real, int N>
Lanes<Real, N> select(LaneMask<Real, N> mask, Lanes<Real, N> a, Lanes<Real, N> b) {
  if constexpr (N == 1)
    return mask.m ? a : b;
  else
    return Lanes<Real, N>::of(mask.m ? a.v : b.v);
}
template <class Real, int N>
bool any(LaneMask<Real, N> mask) {
#if __has_builtin(__builtin_reduce_or)
  if constexpr (N > 1) return __builtin_reduce_or(mask.m) != 0;
#endif
  bool out = false;
  for (int i = 0; i < N; ++i) out = out || mask[i];
  return out;
}
template <class Real, int N>
Lanes<Real, N> sqrt(Lanes<Real, N> x) {
  if constexpr (N == 1) {
    return Lanes<Real, N>(static_cast<Real>(__builtin_sqrt(x.v)));
  } else {
    for (int i = 0; i < N; ++i) x.v[i] = static_cast<Real>(__builtin_sqrt(x.v[i]));
    return x;
  }
}

}  // namespace
}  // namespace ugoki
