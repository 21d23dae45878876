// Travel of walks in place: found by the slides of standing feet, and only where the body does not slide with them.

#include "ugoki/motion/missing_travel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "ugoki/spatial/elementary.h"

namespace ugoki {
namespace {

constexpr double rate = 60, leg = 0.9;
constexpr int frames = 240;

/// Two feet that stand in turn for half a second. A standing foot has the velocity `slide(t)`, a swinging one the opposite one, 10 cm high.
std::vector<FootTrack> walker(const std::function<double(double)>& slide) {
  std::vector<FootTrack> feet(2);
  for (int f = 0; f < frames; ++f)
    for (int k = 0; k < 2; ++k) {
      const bool stands = (static_cast<int>(2 * f / rate) + k) % 2 == 0;
      feet[static_cast<std::size_t>(k)].height.push_back(stands ? 0.02 : 0.12);
      feet[static_cast<std::size_t>(k)].velocity.push_back({(stands ? 1 : -1) * slide(f / rate), 0, 0});
    }
  return feet;
}

std::vector<Vec3> body(double speed) {
  std::vector<Vec3> out;
  for (int f = 0; f < frames; ++f) out.push_back({speed * f / rate, 0, 1});
  return out;
}

double last_x(const MissingTravel& travel) { return travel.shift.back().x; }

constexpr double duration = (frames - 1) / rate;

TEST(MissingTravel, TreadmillHasASteadyTravel) {
  const MissingTravel travel = find_missing_travel(walker([](double) { return -1.2; }), body(0), rate, leg);
  ASSERT_TRUE(travel.exists());
  EXPECT_TRUE(travel.steady);
  EXPECT_NEAR(travel.velocity.x, 1.2, 1e-9);
  EXPECT_NEAR(travel.velocity.y, 0, 1e-9);
  EXPECT_NEAR(last_x(travel), 1.2 * duration, 1e-9);
  EXPECT_EQ(norm(travel.shift.front()), 0);
}

TEST(MissingTravel, ChangingSpeedIsFollowed) {
  const auto speed = [](double t) { return -0.7 * (1 + 0.9 * sin_cos(2 * pi * t / 2).sin); };
  const MissingTravel travel = find_missing_travel(walker(speed), body(0), rate, leg);
  ASSERT_TRUE(travel.exists());
  EXPECT_FALSE(travel.steady);
  double slide = 0, worst = 0;  // m, of the standing feet without and with the travel; within half a second, as long as a stance
  for (int f = 0; f + 30 < frames; ++f) {
    double own = 0;
    for (int k = f; k < f + 30; ++k) own += speed((k + 0.5) / rate) / rate;
    const Vec3 moved = travel.shift[static_cast<std::size_t>(f) + 30] - travel.shift[static_cast<std::size_t>(f)];
    slide = std::max(slide, std::fabs(own));
    worst = std::max(worst, std::fabs(own + moved.x));
  }
  EXPECT_GT(slide, 0.6);
  EXPECT_LT(worst, 0.06);
}

TEST(MissingTravel, WalkThatIsTooSlowGetsTheRest) {
  const MissingTravel travel = find_missing_travel(walker([](double) { return -0.4; }), body(0.9), rate, leg);
  ASSERT_TRUE(travel.exists());
  EXPECT_NEAR(travel.velocity.x, 0.4, 1e-9);
}

TEST(MissingTravel, FeetThatRestNeedNone) {
  EXPECT_FALSE(find_missing_travel(walker([](double) { return 0.0; }), body(1.2), rate, leg).exists());
  EXPECT_FALSE(find_missing_travel(walker([](double) { return 0.1; }), body(0), rate, leg).exists()) << "drift";
}

TEST(MissingTravel, DanceOnTheSpotKeepsItsSlides) {
  for (const double drift : {0.0, 0.35}) {
    const auto slide = [&](double t) { return drift + 0.8 * sin_cos(2 * pi * t / 0.5).sin; };
    EXPECT_FALSE(find_missing_travel(walker(slide), body(0), rate, leg).exists()) << drift;
  }
}

TEST(MissingTravel, SkaterKeepsGliding) {
  EXPECT_FALSE(find_missing_travel(walker([](double) { return 2.0; }), body(2.0), rate, leg).exists());
  EXPECT_FALSE(find_missing_travel(walker([](double t) { return 1.5 + sin_cos(t).sin; }), body(1.6), rate, leg).exists());
}

TEST(MissingTravel, ShortOrEmptyDataHaveNone) {
  EXPECT_FALSE(find_missing_travel({}, body(0), rate, leg).exists());
  EXPECT_FALSE(find_missing_travel(walker([](double) { return -1.2; }), body(0), rate, 0).exists());
  std::vector<FootTrack> feet = walker([](double) { return -1.2; });
  std::vector<Vec3> still = body(0);
  feet.resize(1);
  for (const std::size_t count : {14UL, 28UL}) {
    std::vector<FootTrack> part = feet;
    part[0].height.resize(count);
    part[0].velocity.resize(count);
    still.resize(count, {0, 0, 1});
    EXPECT_EQ(find_missing_travel(part, still, rate, leg).exists(), count > 20) << "a slide of less than a step has none";
  }
}

}  // namespace
}  // namespace ugoki
