// Timing and heights of flights; compared with the laws of free fall and with a jump whose right timing is known.

#include "ugoki/intake/flight_timing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace ugoki::intake {
namespace {

constexpr double g = 9.81, rate = 120;

/// A jump of 0.3 m on the spot: push, flight, landing; played with the speed `speed`.
struct Jump {
  std::vector<Vec3> centre;
  std::vector<double> lowest;
  std::vector<Support> support;
};

/// Height of the centre of mass at t s of the physical jump: down and up with 1 g, take-off at t = 1.
double height_at(double t) {
  const double v = std::sqrt(2 * g * 0.3), time = 2 * v / g, push = v / g;  // m/s, s, s
  if (t > 1 && t < 1 + time) return 1 + v * (t - 1) - 0.5 * g * (t - 1) * (t - 1);
  const double away = t <= 1 ? 1 - t : t - 1 - time;  // before take-off and after landing: decelerated with 1 g
  if (away < push) return 1 - v * away + 0.5 * g * away * away;
  return 1 - 0.5 * v * push;
}

Jump make_jump(double speed) {
  Jump out;
  const double v = std::sqrt(2 * g * 0.3), time = 2 * v / g;
  for (int f = 0; f < static_cast<int>(3 / speed * rate); ++f) {
    const double t = f / rate * speed, z = height_at(t);
    out.centre.push_back({0, 0, z});
    out.lowest.push_back(std::max(0.0, z - 1));
    out.support.push_back(t > 1 && t < 1 + time ? Support::flight : Support::ground);
  }
  return out;
}

TEST(FlightTiming, PlaysAJumpAsGravityWants) {
  for (const double speed : {0.6, 1.0, 1.6}) {
    const Jump jump = make_jump(speed);
    const std::vector<double> w = squared_speeds(jump.centre, jump.support, rate);
    const std::vector<double> given(w.size(), 1.0);
    // Air time with the new clock, against the flight of a body that is thrown 0.3 m high.
    double time = 0;
    for (std::size_t f = 0; f < w.size(); ++f) time += jump.support[f] == Support::flight ? 1 / (rate * std::sqrt(w[f])) : 0;
    EXPECT_NEAR(time, 2 * std::sqrt(2 * 0.3 / g), 0.05) << speed;
    const double before = impossible_acceleration(jump.centre, jump.support, given, rate);
    const double after = impossible_acceleration(jump.centre, jump.support, w, rate);
    EXPECT_LT(after, 0.02) << speed;
    if (speed != 1.0) EXPECT_LT(after, 0.15 * before) << speed;
    EXPECT_NEAR(w.front(), 1, 0.1) << speed;
    EXPECT_NEAR(w.back(), 1, 0.1) << speed;
  }
}

TEST(FlightTiming, KeepsMotionsOnTheGround) {
  std::vector<Vec3> centre;
  for (int f = 0; f < 240; ++f) centre.push_back({1.3 * f / rate, 0, 0.9 + 0.02 * std::sin(4 * f / rate * 3.14159265)});
  const std::vector<Support> support(centre.size(), Support::ground);
  for (const double w : squared_speeds(centre, support, rate)) EXPECT_NEAR(w, 1, 1e-3);
  const std::vector<double> given(centre.size(), 1.0);
  EXPECT_LT(impossible_acceleration(centre, support, given, rate), 1e-6);
}

TEST(FlightTiming, RaisesAFlightThatHangsInTheAir) {
  // The centre of mass stays at one height for 0.5 s without support: no timing lets it fall.
  Jump jump;
  for (int f = 0; f < 240; ++f) {
    const bool flies = f >= 90 && f < 150;
    jump.centre.push_back({0, 0, 1});
    jump.lowest.push_back(flies ? 0.3 : 0);
    jump.support.push_back(flies ? Support::flight : Support::ground);
  }
  const std::vector<double> up = flight_heights(jump.centre, jump.lowest, jump.support, rate);
  double highest = 0;
  for (std::size_t f = 95; f < 145; ++f) {
    EXPECT_NEAR((up[f - 1] - 2 * up[f] + up[f + 1]) * rate * rate, -g, 0.2 * g) << f;
    highest = std::max(highest, up[f]);
  }
  EXPECT_GT(highest, 0.7 * g * 0.5 * 0.5 / 8);
  for (std::size_t f = 0; f < up.size(); ++f) EXPECT_GT(up[f], -jump.lowest[f] - 0.02) << f;
  EXPECT_NEAR(up[10], 0, 0.01);
}

}  // namespace
}  // namespace ugoki::intake
