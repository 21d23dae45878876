#include "ugoki/spatial/elementary.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace ugoki {
namespace {

// pi/2 as sums of parts. For integers n, all products n * part but the last are exact. |n| < 2^20: sum of pio2_a to
// pio2_c; a, b have 33 bits. |n| < 2^26: sum of pio2_far_a to pio2_far_d; far_a and far_b are multiples of 2^-26 and 2^-53, far_c has 27
// bits.
constexpr double pio2_a = 0x1.921fb544p+0;
constexpr double pio2_b = 0x1.0b4611a6p-34;
constexpr double pio2_c = 0x1.3198a2e037073p-69;
constexpr double pio2_far_a = 0x1.921fb54000000p+0;
constexpr double pio2_far_b = 0x1.10b4600000000p-30;
constexpr double pio2_far_c = 0x1.1a62630000000p-54;
constexpr double pio2_far_d = 0x1.8a2e03707344ap-81;

// Sine and cosine of x + tail for |x| <= pi/4, where |tail| is below one unit in the last place of x. Minimax polynomials in x^2 of
// (sin x / x - 1) / x^2 and (cos x - 1 + x^2/2) / x^4, found by the Remez exchange; their relative errors are below 2^-57.
double sin_kernel(double x, double tail) {
  const double z = x * x;
  double s = 0x1.5d932f161657ap-33;
  s = s * z - 0x1.ae5e66d444051p-26;
  s = s * z + 0x1.71de357873a88p-19;
  s = s * z - 0x1.a01a019c126a5p-13;
  s = s * z + 0x1.111111110f881p-7;
  s = s * z - 0x1.5555555555549p-3;
  return x + (x * (z * s) + tail);
}

double cos_kernel(double x, double tail) {
  const double z = x * x;
  double c = -0x1.8faecefbf270ep-37;
  c = c * z + 0x1.1ee9ec474fb94p-29;
  c = c * z - 0x1.27e4f80a75c69p-22;
  c = c * z + 0x1.a01a019cb26e2p-16;
  c = c * z - 0x1.6c16c16c15184p-10;
  c = c * z + 0x1.555555555554cp-5;
  return 1.0 - (0.5 * z - (z * z * c - x * tail));
}

// atan for |x| <= 1/8 by its power series; the first omitted term is below 2^-58 of the result.
double atan_kernel(double x) {
  const double z = x * x;
  double s = 1.0 / 17.0;
  s = s * z - 1.0 / 15.0;
  s = s * z + 1.0 / 13.0;
  s = s * z - 1.0 / 11.0;
  s = s * z + 1.0 / 9.0;
  s = s * z - 1.0 / 7.0;
  s = s * z + 1.0 / 5.0;
  s = s * z - 1.0 / 3.0;
  return x + x * (z * s);
}

// atan(i / 8) for i = 0 ... 8, correctly rounded. atan_rest contains the rounding errors (exact minus rounded).
constexpr double atan_table[9] = {0.0,
                                  0x1.fd5ba9aac2f6ep-4,
                                  0x1.f5b75f92c80ddp-3,
                                  0x1.6f61941e4def1p-2,
                                  0x1.dac670561bb4fp-2,
                                  0x1.1e00babdefeb4p-1,
                                  0x1.4978fa3269ee1p-1,
                                  0x1.700a7c5784634p-1,
                                  0x1.921fb54442d18p-1};
constexpr double atan_rest[9] = {0.0,
                                 -0x1.cd37686760c17p-59,
                                 0x1.8ab6e3cf7afbdp-57,
                                 -0x1.c63aae6f6e918p-56,
                                 0x1.a2b7f222f65e2p-56,
                                 -0x1.928df287a668fp-58,
                                 0x1.2419a87f2a458p-56,
                                 -0x1.8c34d25aadef6p-56,
                                 0x1.1a62633145c07p-55};

/// A value as an unevaluated sum head + tail, where |tail| is below one unit in the last place of head.
struct Split {
  double head, tail;
};
constexpr Split half_turn{pi, 0x1.1a62633145c07p-53};
constexpr Split quarter_turn{pi / 2, 0x1.1a62633145c07p-54};

// atan of t in [0, 1] as atan c + atan((t - c) / (1 + t c)). c is the multiple of 1/8 nearest to t; for t below 1/8, c = 0.
Split atan_unit(double t) {
  const int i = t < 0.125 ? 0 : static_cast<int>(t * 8.0 + 0.5);
  const double c = i * 0.125;
  const double rest = atan_rest[i] + atan_kernel((t - c) / (1.0 + t * c));
  const double head = atan_table[i] + rest;
  return {head, rest - (head - atan_table[i])};
}

Split minus(const Split& a, const Split& b) {  // requires a.head > b.head
  const double head = a.head - b.head;
  return {head, ((a.head - head) - b.head) + (a.tail - b.tail)};
}

}  // namespace

SinCos sin_cos(double x) {
  if (!(x > -1e8 && x < 1e8)) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    return {nan, nan};
  }
  // Argument reduction: x - n pi/2 = r + tail. All products of n with parts of pi/2 are exact, except the last.
  // Adding and subtracting 1.5 * 2^52 rounds to the integer n. The low bits of the sum `shifted` are those of n.
  constexpr double magic = 0x1.8p52;
  const double shifted = x * (2.0 / pi) + magic;
  const double n = shifted - magic;
  double head, small, smaller;
  if (n * n < 0x1p40) {
    head = (x - n * pio2_a) - n * pio2_b;
    small = n * pio2_c;
    smaller = 0.0;
  } else {
    head = (x - n * pio2_far_a) - n * pio2_far_b;
    small = n * pio2_far_c;
    smaller = n * pio2_far_d;
  }
  const double r = head - small;
  const double tail = ((head - r) - small) - smaller;
  const double s = sin_kernel(r, tail), c = cos_kernel(r, tail);
  switch (std::bit_cast<std::uint64_t>(shifted) & 3) {
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
  Split angle;
  if (std::isinf(ax) && std::isinf(ay)) {
    angle = atan_unit(1.0);
  } else if (ay <= ax) {
    angle = atan_unit(ay / ax);
  } else {
    angle = minus(quarter_turn, atan_unit(ax / ay));
  }
  if (x < 0.0) angle = minus(half_turn, angle);
  const double value = angle.head + angle.tail;
  return y < 0.0 ? -value : value;
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
  constexpr double ln2_a = 0x1.62e42feep-1;  // ln 2 = ln2_a + ln2_b; ln2_a has 33 bits, so that n * ln2_a is exact
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
