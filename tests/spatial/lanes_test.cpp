// Sine and cosine in SIMD lanes: doubles must have the bits of the scalar functions, floats must be accurate.

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include "ugoki/spatial/elementary.h"
#include "ugoki/spatial/lanes_elementary.h"

namespace ugoki {
namespace {

std::vector<double> hard_angles() {
  std::vector<double> x = {0.0, -0.0, 1e-300, 5e-324, 1e8, -1e8, 99999999.9, 1e9, INFINITY, -INFINITY, NAN, 0x1p20 * pi / 2};
  for (int n = -3000; n <= 3000; ++n)
    for (const double y : {n * (pi / 4), std::nextafter(n * (pi / 4), 1e9), std::nextafter(n * (pi / 4), -1e9)}) x.push_back(y);
  std::mt19937_64 engine(3);
  for (const double reach : {1.0, 10.0, 1e3, 1.6e6, 1.7e6, 1e8}) {
    std::uniform_real_distribution<double> uniform(-reach, reach);
    for (int i = 0; i < 5000; ++i) x.push_back(uniform(engine));
  }
  while (x.size() % 8 != 0) x.push_back(1.0);
  return x;
}

bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b) || (std::isnan(a) && std::isnan(b));
}

template <int N>
void expect_scalar_bits() {
  const std::vector<double> x = hard_angles();
  for (std::size_t i = 0; i < x.size(); i += N) {
    double s[N], c[N];
    const auto sc = lane_sin_cos(Lanes<double, N>::load(x.data() + i));
    sc.sin.store(s);
    sc.cos.store(c);
    for (std::size_t k = 0; k < N; ++k) {
      ASSERT_TRUE(same_bits(s[k], sin(x[i + k]))) << "sin " << x[i + k] << " in " << N << " lanes";
      ASSERT_TRUE(same_bits(c[k], cos(x[i + k]))) << "cos " << x[i + k] << " in " << N << " lanes";
    }
  }
}
TEST(Lanes, SineAndCosineOfDoublesHaveTheScalarBits) {
  expect_scalar_bits<1>();
  expect_scalar_bits<2>();
  expect_scalar_bits<4>();
  expect_scalar_bits<8>();
}

TEST(Lanes, SineAndCosineOfFloatsAreAccurate) {
  std::mt19937_64 engine(4);
  for (const float reach : {1.0f, 10.0f, 1000.0f, 10000.0f}) {
    std::uniform_real_distribution<float> uniform(-reach, reach);
    for (int i = 0; i < 20000; i += 4) {
      float x[4], s[4], c[4];
      for (float& y : x) y = uniform(engine);
      const auto sc = lane_sin_cos(Lanes<float, 4>::load(x));
      sc.sin.store(s);
      sc.cos.store(c);
      for (int k = 0; k < 4; ++k) {
        ASSERT_NEAR(s[k], std::sin(static_cast<double>(x[k])), 1.2e-7) << x[k];
        ASSERT_NEAR(c[k], std::cos(static_cast<double>(x[k])), 1.2e-7) << x[k];
      }
    }
  }
  for (const float x : {2e5f, -2e5f, INFINITY, NAN}) EXPECT_TRUE(std::isnan(lane_sin_cos(Lanes<float, 1>(x)).sin.v));
}

TEST(Lanes, OperatorsWorkLaneByLane) {
  const double a[] = {1, -2, 9, 0.25}, b[] = {4, -2, 3, -0.5};
  using T = Lanes<double, 4>;
  const T x = T::load(a), y = T::load(b);
  double sum[4], product[4], quotient[4], root[4], chosen[4];
  (x + y).store(sum);
  (x * y).store(product);
  (x / y).store(quotient);
  sqrt(x * x).store(root);
  select(x > y, x, y).store(chosen);
  for (int k = 0; k < 4; ++k) {
    EXPECT_EQ(sum[k], a[k] + b[k]);
    EXPECT_EQ(product[k], a[k] * b[k]);
    EXPECT_EQ(quotient[k], a[k] / b[k]);
    EXPECT_EQ(root[k], std::fabs(a[k]));
    EXPECT_EQ(chosen[k], std::max(a[k], b[k]));
  }
  EXPECT_TRUE(any(x > y));
  EXPECT_FALSE(any(x > T(9.0)));
}

}  // namespace
}  // namespace ugoki
