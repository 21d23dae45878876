#pragma once
// Jacobi's elliptic functions by the arithmetic-geometric mean (Abramowitz, Stegun 16.4, 17.6), for closed-form solutions in tests.

#include <cmath>

namespace ugoki::testing {

/// Complete elliptic integral of the first kind K(k), modulus k.
inline double elliptic_K(double k) {
  double a = 1, g = std::sqrt(1 - k * k);
  for (int i = 0; i < 40; ++i) {
    const double mean = 0.5 * (a + g);
    g = std::sqrt(a * g);
    a = mean;
  }
  return std::acos(-1.0) / (2 * a);
}

/// Values of Jacobi's elliptic functions.
struct Jacobi {
  double sn, cn, dn;
};
/// sn(u, k), cn(u, k) and dn(u, k), modulus k.
inline Jacobi jacobi(double u, double k) {
  double a[20], c[20];
  a[0] = 1;
  c[0] = k;
  double b = std::sqrt(1 - k * k);
  int n = 0;
  while (n < 18 && std::fabs(c[n]) > 1e-17) {
    a[n + 1] = 0.5 * (a[n] + b);
    c[n + 1] = 0.5 * (a[n] - b);
    b = std::sqrt(a[n] * b);
    ++n;
  }
  double phi = std::ldexp(a[n] * u, n);
  for (; n > 0; --n) phi = 0.5 * (phi + std::asin(c[n] / a[n] * std::sin(phi)));
  const double sn = std::sin(phi);
  return {sn, std::cos(phi), std::sqrt(1 - k * k * sn * sn)};
}

}  // namespace ugoki::testing
