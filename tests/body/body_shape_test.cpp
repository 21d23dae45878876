// Shapes and soles of bodies.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "measured_files.h"
#include "ugoki/body/body.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion/measures.h"

namespace ugoki::body {
namespace {

/// Lowest and highest point [m] of the shapes for which `wanted` returns true.
template <class F>
std::pair<double, double> extent_z(const Mechanism& m, const std::vector<Pose>& X, F wanted) {
  double low = 1e300, high = -1e300;
  for (int i = 0; i < m.link_count(); ++i)
    for (const Shape& s : m.link(i).shapes) {
      if (!wanted(s)) continue;
      const Pose P = X[static_cast<std::size_t>(i)] * s.X_BS;
      const Vec3 up = P.R.row(2);
      const double reach = s.type == ShapeType::box ? std::fabs(up.x) * s.half_extents.x + std::fabs(up.y) * s.half_extents.y +
                                                          std::fabs(up.z) * s.half_extents.z
                                                    : s.radius + s.half_length * std::fabs(up.z);
      low = std::min(low, P.p.z - reach);
      high = std::max(high, P.p.z + reach);
    }
  return {low, high};
}

TEST(BodyShapes, SyntheticCharacterStandsFlatOnTheFloorAtFullHeight) {
  const MeasuredMotion measured = testing::made_character();
  BodyOptions options;
  options.height = 1.75;
  const auto body = make_body(measured, options);
  ASSERT_TRUE(body.has_value());
  const Motion motion = to_motion(*body, measured);
  const Mechanism& m = *body->mechanism;
  std::vector<Pose> X(static_cast<std::size_t>(m.link_count()));
  calc_poses(m, std::span(motion.frame(0), static_cast<std::size_t>(m.nq())), X);
  const auto [low, high] = extent_z(m, X, [](const Shape& s) { return s.collides; });
  EXPECT_NEAR(low, 0, 1e-6);
  EXPECT_NEAR(high, 1.75, 0.12);
  const auto [seen_low, seen_high] = extent_z(m, X, [](const Shape& s) { return s.visible; });
  EXPECT_NEAR(seen_low, 0, 0.003);
  EXPECT_NEAR(seen_high, high, 1e-9);
  // Both soles: the box touches the floor with all bottom corners, and the heel is behind the ankle.
  for (const int foot : find_feet(m)) {
    int on_floor = 0;
    double back = 1e9, front = -1e9;
    for (const SupportPoint& p : support_points(m.link(foot))) {
      const Vec3 w = X[static_cast<std::size_t>(foot)] * p.p;
      on_floor += std::fabs(w.z - p.radius) < 1e-6 ? 1 : 0;
      back = std::min(back, w.x - p.radius - X[static_cast<std::size_t>(foot)].p.x);
      front = std::max(front, w.x - X[static_cast<std::size_t>(foot)].p.x);
    }
    EXPECT_GE(on_floor, 4) << m.link(foot).name;
    if (m.link(foot).label.starts_with("foot")) {
      EXPECT_LT(back, -0.04);
      EXPECT_GT(front, 0.12);
    }
  }
  EXPECT_EQ(find_feet(m).size(), 2u);  // toes bear no load
}

TEST(BodyShapes, MeasuredCharactersStandOnTheFloorAtTheirHeight) {
  const std::vector<std::string> files = testing::human_files();
  if (files.empty()) GTEST_SKIP() << "The shared measured data are absent.";
  for (const char* file : {"asf_amc/35_01.amc", "asf_amc/07_01.amc", "bvh/cmu_12_01_walk.bvh"}) {
    SCOPED_TRACE(file);
    const MeasuredMotion measured = testing::read(file);
    const auto body = make_body(measured);
    ASSERT_TRUE(body.has_value());
    const Mechanism& m = *body->mechanism;
    const Motion motion = to_motion(*body, measured);
    // In frames in which a foot stands still, the median distance of its sole from the floor is below 6 mm.
    std::vector<Pose> X(static_cast<std::size_t>(m.link_count())), before(X);
    std::vector<double> deviations;
    for (int f = 1; f < motion.frames; ++f) {
      calc_poses(m, std::span(motion.frame(f - 1), static_cast<std::size_t>(m.nq())), before);
      calc_poses(m, std::span(motion.frame(f), static_cast<std::size_t>(m.nq())), X);
      for (const Sole& sole : body->soles) {
        const int link = body->link_of_joint[static_cast<std::size_t>(sole.foot)];
        const auto i = static_cast<std::size_t>(link);
        if (norm(X[i].p - before[i].p) * motion.rate > 0.12 || norm(X[i] * sole.ball - before[i] * sole.ball) * motion.rate > 0.12)
          continue;
        double low = 1e9;
        for (const SupportPoint& p : support_points(m.link(link))) low = std::min(low, (X[i] * p.p).z - p.radius);
        deviations.push_back(std::fabs(low));
      }
    }
    ASSERT_GT(deviations.size(), 20u);
    std::nth_element(deviations.begin(), deviations.begin() + static_cast<std::ptrdiff_t>(deviations.size() / 2), deviations.end());
    EXPECT_LT(deviations[deviations.size() / 2], 0.006);
    // While walking, the top of the head is about the body's height above the floor.
    calc_poses(m, std::span(motion.frame(motion.frames / 2), static_cast<std::size_t>(m.nq())), X);
    const auto [low, high] = extent_z(m, X, [](const Shape& s) { return s.visible; });
    // The tolerance is large because BVH files of this collection lack the bone of the upper chest, which is about 10 cm long.
    EXPECT_NEAR(high, body->height, 0.23);
    EXPECT_GT(low, -0.04);
  }
}

}  // namespace
}  // namespace ugoki::body
