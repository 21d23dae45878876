// A hovering character is lowered no faster than gravity pulls it; compared with the laws of free fall.

#include "ugoki/intake/lowering.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "ugoki/spatial/elementary.h"

namespace ugoki::intake {
namespace {

TEST(Lowering, IsNoFasterThanGravity) {
  // The limbs are drawn up by 25 cm within one frame, and reach the floor again 0.3 s later; the centre of mass stays at its height.
  constexpr double rate = 60, drawn = 0.25;
  const std::size_t n = 120, first = 50, last = 67;
  std::vector<double> lift(n, 0.0);
  const std::vector<double> centre(n, 0.5);
  for (std::size_t f = first; f <= last; ++f) lift[f] = drawn;
  const std::vector<double> down = physical_lowering(lift, std::vector<std::uint8_t>(n, 0), centre, rate);
  double lowest = 0, flight = 0;
  for (std::size_t f = 1; f + 1 < n; ++f) {
    const double acceleration = -(down[f - 1] - 2 * down[f] + down[f + 1]) * rate * rate;
    EXPECT_GT(acceleration, -1.15 * 9.81) << f;
    EXPECT_LT(acceleration, 1.75 * 1.15 * 9.81) << f;
    if (f >= first && f <= last && acceleration < -0.85 * 9.81) ++flight;
    lowest = std::max(lowest, down[f]);
  }
  EXPECT_GT(lowest, 0.03);
  EXPECT_LT(lowest, drawn + 0.01) << "the limbs stay above the floor";
  EXPECT_GE(flight, 3) << "it falls freely";
  EXPECT_NEAR(down[10], 0, 1e-3);
  EXPECT_NEAR(down[n - 10], 0, 1e-3);
  // A flight that needs twice the gravity becomes lower; one that falls with gravity stays.
  for (const double gravities : {1.0, 2.0}) {
    std::vector<double> flying(n, 0.5), above(n, 0.0);
    std::vector<std::uint8_t> flies(n, 0);
    for (std::size_t f = 40; f <= 64; ++f) {
      const double t = (static_cast<double>(f) - 40) / rate, time = 24 / rate;
      above[f] = 0.5 * gravities * 9.81 * t * (time - t);
      flying[f] += above[f];
      flies[f] = f > 40 && f < 64 ? 1 : 0;
    }
    const std::vector<double> lower = physical_lowering(above, flies, flying, rate);
    const double apex = above[52] - lower[52];
    EXPECT_NEAR(apex, 0.5 * 9.81 * 0.2 * 0.2, gravities > 1 ? 0.05 : 0.02) << gravities;
    for (std::size_t f = 0; f < n; ++f) EXPECT_LT(lower[f], above[f] + 0.02) << "the feet stay above the floor: " << f;
  }
  // A slow change of the height is followed.
  for (std::size_t f = 0; f < n; ++f) lift[f] = 0.1 * (1 - sin_cos(2 * pi * static_cast<double>(f) / static_cast<double>(n)).cos);
  const std::vector<double> slow = physical_lowering(lift, std::vector<std::uint8_t>(n, 0), centre, rate);
  for (std::size_t f = 0; f < n; ++f) EXPECT_NEAR(slow[f], lift[f], 0.01) << f;
}

}  // namespace
}  // namespace ugoki::intake
