#include "ugoki/spatial/elementary.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace ugoki {
namespace {

// pi/2 in three parts: the first two have 33 significant bits each, so that n * part is exact for |n| < 2^20.
constexpr double pio2_a = 0x1.921fb544p+0;
constexpr double pio2_b = 0x1.0b4611a6p-34;
constexpr double pio2_c = 0x1.3198a2e037073p-69;

// Taylor series; on |x| <= pi/4 the first term left out is below 2^-60 of the result.
double sin_kernel(double x) {
  const double z = x * x;
  double s = 1.0 / 355687428096000.0;       // 1/17!
  s = s * z - 1.0 / 1307674368000.0;        // 1/15!
  s = s * z + 1.0 / 6227020800.0;           // 1/13!
  s = s * z - 1.0 / 39916800.0;             // 1/11!
  s = s * z + 1.0 / 362880.0;               // 1/9!
  s = s * z - 1.0 / 5040.0;
  s = s * z + 1.0 / 120.0;
  s = s * z - 1.0 / 6.0;
  return x + x * (z * s);
}

double cos_kernel(double x) {
  const double z = x * x;
  double c = 1.0 / 20922789888000.0;        // 1/16!
  c = c * z - 1.0 / 87178291200.0;          // 1/14!
  c = c * z + 1.0 / 479001600.0;            // 1/12!
  c = c * z - 1.0 / 3628800.0;              // 1/10!
  c = c * z + 1.0 / 40320.0;                // 1/8!
  c = c * z - 1.0 / 720.0;
  c = c * z + 1.0 / 24.0;
  const double half = 0.5 * z;
  const double head = 1.0 - half;           // keep what the subtraction rounded away
  return head + (((1.0 - head) - half) + z * z * c);
}

// atan on |x| <= 1/16 around the nearest multiple of 1/8, by its series.
double atan_kernel(double x) {
  const double z = x * x;
  double s = 1.0 / 13.0;
  s = s * z - 1.0 / 11.0;
  s = s * z + 1.0 / 9.0;
  s = s * z - 1.0 / 7.0;
  s = s * z + 1.0 / 5.0;
  s = s * z - 1.0 / 3.0;
  return x + x * (z * s);
}

// atan(i / 8) for i = 0 ... 8, correctly rounded.
constexpr double atan_table[9] = {0.0,
                                  0.12435499454676143503,
                                  0.24497866312686415417,
                                  0.35877067027057222042,
                                  0.46364760900080611621,
                                  0.55859931534356243597,
                                  0.64350110879328438680,
                                  0.71882999962162450542,
                                  0.78539816339744830962};

// atan of t in [0, 1].
double atan_unit(double t) {
  const int i = static_cast<int>(t * 8.0 + 0.5);
  const double c = i * 0.125;
  return atan_table[i] + atan_kernel((t - c) / (1.0 + t * c));
}

}  // namespace

SinCos sin_cos(double x) {
  if (!(x > -1e8 && x < 1e8)) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    return {nan, nan};
  }
  const double n = std::floor(x * (2.0 / pi) + 0.5);
  const double head = (x - n * pio2_a) - n * pio2_b;
  const double r = head - n * pio2_c;
  const double s = sin_kernel(r), c = cos_kernel(r);
  switch (static_cast<std::int64_t>(n) & 3) {
    case 0: return {s, c};
    case 1: return {c, -s};
    case 2: return {-s, -c};
    default: return {-c, s};
  }
}

double sin(double x) { return sin_cos(x).sin; }
double cos(double x) { return sin_cos(x).cos; }
double tan(double x) {
  const SinCos sc = sin_cos(x);
  return sc.sin / sc.cos;
}

double atan2(double y, double x) {
  if (std::isnan(x) || std::isnan(y)) return std::numeric_limits<double>::quiet_NaN();
  const double ax = std::fabs(x), ay = std::fabs(y);
  if (ax == 0.0 && ay == 0.0) return 0.0;
  double angle;
  if (std::isinf(ax) && std::isinf(ay)) {
    angle = pi / 4;
  } else if (ay <= ax) {
    angle = atan_unit(ay / ax);
  } else {
    angle = (pi / 2) - atan_unit(ax / ay);
  }
  if (x < 0.0) angle = pi - angle;
  return y < 0.0 ? -angle : angle;
}

double atan(double x) { return atan2(x, 1.0); }

double asin(double x) {
  if (x >= 1.0) return pi / 2;
  if (x <= -1.0) return -pi / 2;
  return atan2(x, std::sqrt((1.0 - x) * (1.0 + x)));
}

double acos(double x) {
  if (x >= 1.0) return 0.0;
  if (x <= -1.0) return pi;
  return atan2(std::sqrt((1.0 - x) * (1.0 + x)), x);
}

double exp(double x) {
  if (std::isnan(x)) return x;
  if (x > 709.782712893384) return std::numeric_limits<double>::infinity();
  if (x < -745.2) return 0.0;
  constexpr double ln2_a = 0x1.62e42feep-1;  // 33 bits
  constexpr double ln2_b = 0x1.a39ef35793c76p-33;
  const double n = std::floor(x * 1.44269504088896340736 + 0.5);
  const double r = (x - n * ln2_a) - n * ln2_b;
  double s = 1.0 / 6227020800.0;
  s = s * r + 1.0 / 479001600.0;
  s = s * r + 1.0 / 39916800.0;
  s = s * r + 1.0 / 3628800.0;
  s = s * r + 1.0 / 362880.0;
  s = s * r + 1.0 / 40320.0;
  s = s * r + 1.0 / 5040.0;
  s = s * r + 1.0 / 720.0;
  s = s * r + 1.0 / 120.0;
  s = s * r + 1.0 / 24.0;
  s = s * r + 1.0 / 6.0;
  s = s * r + 0.5;
  const double e = 1.0 + (r + r * (r * s));
  const int k = static_cast<int>(n);
  const auto power = [](int p) { return std::bit_cast<double>(static_cast<std::uint64_t>(p + 1023) << 52); };
  return k > 1000 ? e * power(k - 200) * power(200) : k < -1000 ? e * power(k + 200) * power(-200) : e * power(k);
}

double log(double x) {
  if (std::isnan(x) || x < 0.0) return std::numeric_limits<double>::quiet_NaN();
  if (x == 0.0) return -std::numeric_limits<double>::infinity();
  if (std::isinf(x)) return x;
  int k = 0;
  if (x < std::numeric_limits<double>::min()) {
    x *= 0x1p54;
    k = -54;
  }
  const auto bits = std::bit_cast<std::uint64_t>(x);
  k += static_cast<int>(bits >> 52) - 1023;
  double m = std::bit_cast<double>((bits & 0xfffffffffffffULL) | (1023ULL << 52));
  if (m > 1.41421356237309504880) {
    m *= 0.5;
    ++k;
  }
  // log m = 2 atanh(f), f = (m - 1) / (m + 1), |f| < 0.172
  const double f = (m - 1.0) / (m + 1.0);
  const double z = f * f;
  double s = 1.0 / 21.0;
  for (int d = 19; d >= 3; d -= 2) s = s * z + 1.0 / d;
  constexpr double ln2_a = 0x1.62e42feep-1;
  constexpr double ln2_b = 0x1.a39ef35793c76p-33;
  return k * ln2_a + (2.0 * f + (2.0 * f * (z * s) + k * ln2_b));
}

double pow(double x, double y) { return exp(y * log(x)); }

}  // namespace ugoki
