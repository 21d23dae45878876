// Compares the elementary functions with the 80-bit functions of the C library, in units in the last place (ulp).

#include "ugoki/spatial/elementary.h"

#include <gtest/gtest.h>

#include <cfloat>
#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "ugoki/base/hash.h"
#include "ugoki/base/number.h"

namespace ugoki {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
const double nan_value = std::numeric_limits<double>::quiet_NaN();

/// |value - exact| in units in the last place of the exact result.
double ulps(double value, long double exact) {
  const double nearest = static_cast<double>(exact);
  if (std::isinf(nearest) || std::isnan(nearest)) return value == nearest || std::isnan(value) == std::isnan(nearest) ? 0.0 : infinity;
  int exponent = 0;
  (void)std::frexp(nearest, &exponent);
  const double unit = std::ldexp(1.0, std::max(exponent - DBL_MANT_DIG, -1074));
  return static_cast<double>(std::fabs(static_cast<long double>(value) - exact) / static_cast<long double>(unit));
}

struct Range {
  double low, high;
};

class Elementary : public testing::Test {
 protected:
  void SetUp() override {
    if (LDBL_MANT_DIG < 64) GTEST_SKIP() << "long double is not wider than double here, so there is no reference.";
  }
  using Ours = std::function<double(double)>;
  using Exact = std::function<long double(long double)>;
  /// Expects errors below `limit` ulp at random points: uniform in the range, and uniform in the exponent where the range allows.
  void expect_within(double limit, Range range, const Ours& ours, const Exact& exact) {
    const int count = 60000;
    std::mt19937_64 engine(5);
    double maximum = 0, where = 0;
    const auto check = [&](double x) {
      const double e = ulps(ours(x), exact(static_cast<long double>(x)));
      if (!(e <= maximum)) {
        maximum = e;
        where = x;
      }
    };
    std::uniform_real_distribution<double> uniform(range.low, range.high);
    for (int i = 0; i < count; ++i) check(uniform(engine));
    const double reach = std::max(std::fabs(range.low), std::fabs(range.high));
    std::uniform_real_distribution<double> power(-60, std::log2(reach));
    for (int i = 0; i < count / 2; ++i) {
      const double x = std::exp2(power(engine));
      if (x >= range.low && x <= range.high) check(x);
      if (-x >= range.low && -x <= range.high) check(-x);
    }
    EXPECT_LT(maximum, limit) << "ulp, at " << to_text(where) << " in [" << range.low << ", " << range.high << "]";
  }
};

TEST_F(Elementary, SineAndCosine) {
  for (const Range r : {Range{-0.8, 0.8}, Range{-4, 4}, Range{-100, 100}, Range{-1e5, 1e5}, Range{-1e8, 1e8}}) {
    expect_within(2, r, [](double x) { return ugoki::sin(x); }, [](long double x) { return std::sin(x); });
    expect_within(2, r, [](double x) { return ugoki::cos(x); }, [](long double x) { return std::cos(x); });
  }
  // Next to the zeros of sine and cosine, where the argument reduction must keep every digit.
  double maximum = 0;
  for (int n = 1; n < 2000; ++n) {
    const double x = n * (pi / 2);
    for (const double y : {x, std::nextafter(x, 0.0), std::nextafter(x, 1e9)}) {
      maximum = std::max(maximum, ulps(ugoki::sin(y), std::sin(static_cast<long double>(y))));
      maximum = std::max(maximum, ulps(ugoki::cos(y), std::cos(static_cast<long double>(y))));
    }
  }
  EXPECT_LT(maximum, 2);
}

TEST_F(Elementary, Tangent) {
  for (const Range r : {Range{-1.5, 1.5}, Range{-100, 100}})
    expect_within(3, r, [](double x) { return ugoki::tan(x); }, [](long double x) { return std::tan(x); });
}

TEST_F(Elementary, Arctangent) {
  for (const Range r : {Range{-1, 1}, Range{-10, 10}, Range{-1e6, 1e6}})
    expect_within(2, r, [](double x) { return ugoki::atan(x); }, [](long double x) { return std::atan(x); });
  for (const double x : {-3.0, -1.0, -1e-3, 1e-3, 0.7, 5.0})
    expect_within(
        2, {-4, 4}, [x](double y) { return ugoki::atan2(y, x); },
        [x](long double y) { return std::atan2(y, static_cast<long double>(x)); });
}

TEST_F(Elementary, ArcsineAndArccosine) {
  expect_within(3, {-1, 1}, [](double x) { return ugoki::asin(x); }, [](long double x) { return std::asin(x); });
  expect_within(3, {-1, 1}, [](double x) { return ugoki::acos(x); }, [](long double x) { return std::acos(x); });
  expect_within(3, {1 - 1e-6, 1}, [](double x) { return ugoki::acos(x); }, [](long double x) { return std::acos(x); });
}

TEST_F(Elementary, ExponentialAndLogarithm) {
  for (const Range r : {Range{-1, 1}, Range{-50, 50}, Range{-745, 709.7}})
    expect_within(2, r, [](double x) { return ugoki::exp(x); }, [](long double x) { return std::exp(x); });
  for (const Range r : {Range{0.5, 2}, Range{0.99, 1.01}, Range{1e-300, 10}, Range{1, 1e300}})
    expect_within(2, r, [](double x) { return ugoki::log(x); }, [](long double x) { return std::log(x); });
  EXPECT_LT(ulps(ugoki::log(0x1p-1074), std::log(0x1p-1074L)), 2);
  EXPECT_LT(ulps(ugoki::log(1e-310), std::log(static_cast<long double>(1e-310))), 2);
}

TEST_F(Elementary, Power) {
  // The exponent multiplies the error of the logarithm.
  std::mt19937_64 engine(9);
  std::uniform_real_distribution<double> base(0.01, 20), exponent(-8, 8);
  for (int i = 0; i < 100000; ++i) {
    const double x = base(engine), y = exponent(engine);
    const double allowed = 2 + 2 * std::fabs(y * std::log(x));
    ASSERT_LT(ulps(ugoki::pow(x, y), std::pow(static_cast<long double>(x), static_cast<long double>(y))), allowed) << x << " ^ " << y;
  }
}

TEST(ElementaryEdges, ExactAndSpecialValues) {
  EXPECT_EQ(ugoki::sin(0.0), 0.0);
  EXPECT_EQ(ugoki::cos(0.0), 1.0);
  EXPECT_EQ(ugoki::exp(0.0), 1.0);
  EXPECT_EQ(ugoki::log(1.0), 0.0);
  EXPECT_EQ(ugoki::atan2(0.0, 0.0), 0.0);
  EXPECT_EQ(ugoki::atan2(0.0, -1.0), pi);
  EXPECT_EQ(ugoki::atan2(1.0, 0.0), pi / 2);
  EXPECT_EQ(ugoki::atan2(-1.0, 0.0), -pi / 2);
  EXPECT_EQ(ugoki::atan2(infinity, infinity), pi / 4);
  EXPECT_EQ(ugoki::atan2(1.0, infinity), 0.0);
  EXPECT_EQ(ugoki::atan2(1.0, -infinity), pi);
  EXPECT_EQ(ugoki::acos(1.0), 0.0);
  EXPECT_EQ(ugoki::acos(-1.0), pi);
  EXPECT_EQ(ugoki::acos(1.0000001), 0.0);  // clamped
  EXPECT_EQ(ugoki::asin(-7.0), -pi / 2);
  EXPECT_EQ(ugoki::exp(710.0), infinity);
  EXPECT_EQ(ugoki::exp(-infinity), 0.0);
  EXPECT_EQ(ugoki::exp(-746.0), 0.0);
  EXPECT_GT(ugoki::exp(-745.0), 0.0);
  EXPECT_LT(ugoki::exp(709.78), infinity);
  EXPECT_EQ(ugoki::log(0.0), -infinity);
  EXPECT_EQ(ugoki::log(infinity), infinity);
  EXPECT_TRUE(std::isnan(ugoki::log(-1.0)));
  EXPECT_EQ(ugoki::pow(2.0, 0.0), 1.0);
  for (const auto f : {ugoki::sin, ugoki::cos, ugoki::tan, ugoki::asin, ugoki::acos, ugoki::atan, ugoki::exp, ugoki::log})
    EXPECT_TRUE(std::isnan(f(nan_value)));
  EXPECT_TRUE(std::isnan(ugoki::atan2(nan_value, 1.0)) && std::isnan(ugoki::atan2(1.0, nan_value)));
  EXPECT_TRUE(std::isnan(ugoki::sin(infinity)) && std::isnan(ugoki::cos(-infinity)));
}

TEST(ElementaryEdges, Symmetries) {
  std::mt19937_64 engine(1);
  std::uniform_real_distribution<double> uniform(-50, 50);
  for (int i = 0; i < 20000; ++i) {
    const double x = uniform(engine);
    ASSERT_EQ(ugoki::atan(-x), -ugoki::atan(x));
    ASSERT_EQ(ugoki::sin_cos(x).sin, ugoki::sin(x));
    ASSERT_EQ(ugoki::sin_cos(x).cos, ugoki::cos(x));
    const SinCos sc = sin_cos(x);
    ASSERT_NEAR(sc.sin * sc.sin + sc.cos * sc.cos, 1, 4e-16);
    ASSERT_LE(std::fabs(sc.sin), 1.0);
    ASSERT_LE(std::fabs(sc.cos), 1.0);
    ASSERT_NEAR(ugoki::sin(-x), -ugoki::sin(x), 1e-15);
  }
}

// Results must have the same bits on every compiler, optimisation level and machine. The hash was computed with clang 19 at -O3.
TEST(ElementaryEdges, SameBitsEverywhere) {
  Hash64 hash;
  for (int i = -2000; i <= 2000; ++i) {
    const double x = i * 0.0137;
    hash.add(ugoki::sin(x));
    hash.add(ugoki::cos(x));
    hash.add(ugoki::tan(x));
    hash.add(ugoki::atan2(x, 0.7));
    hash.add(ugoki::asin(x / 30));
    hash.add(ugoki::acos(x / 30));
    hash.add(ugoki::exp(x));
    hash.add(ugoki::log(std::fabs(x) + 0.01));
  }
  EXPECT_EQ(hash.hex(), "53bbbef515d3db97");
}

}  // namespace
}  // namespace ugoki
