// Physics correction by sampling: a roll made by hand becomes a motion that needs no force but those of the floor.

#include "ugoki/correction/rehearse.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "keyed_pose.h"
#include "keyed_roll.h"
#include "ugoki/collision/scene.h"
#include "ugoki/dynamics/centroidal.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/samples/samples.h"

namespace ugoki::correction {
namespace {

/// The forces that move the centre of mass of a motion, from its frames alone.
struct Forces {
  double pull = 0;      // body weights: maximum force downwards, which no floor can supply
  double friction = 0;  // rms, body weights: horizontal force beyond the friction of the floor
  double flight = 0;    // rms, body weights: force while no shape is closer to the floor than 2 cm
};

Forces forces_of(const MechanismPtr& mechanism, const Motion& motion, double mu) {
  const Mechanism& m = *mechanism;
  constexpr int apart = 3;  // frames between the positions of the second difference
  const auto nq = static_cast<std::size_t>(motion.nq);
  dynamics::Workspace ws(m);
  const std::vector<double> rest(static_cast<std::size_t>(m.nv()));
  const collision::Scene scene({mechanism});
  collision::Workspace memory(scene);
  std::vector<collision::ContactPoint> contacts;
  std::vector<Pose> X(m.links().size());
  const auto touches = [&](int f) {
    calc_poses(m, std::span(motion.frame(f), nq), X);
    const std::span<const Pose> poses(X);
    collision::find_contacts(scene, std::span(&poses, 1), 0.02, memory, contacts);
    return std::ranges::any_of(contacts, [](const collision::ContactPoint& c) { return c.system_b < 0; });
  };
  const auto centre = [&](int f) {
    dynamics::update_kinematics(m, std::span(motion.frame(f), nq), rest, ws);
    return dynamics::calc_centroidal(m, ws).centre;
  };
  Forces out;
  int count = 0, free = 0;
  for (int f = apart; f + apart < motion.frames; ++f, ++count) {
    const double h = apart / motion.rate;
    const Vec3 a = (centre(f - apart) - centre(f) * 2.0 + centre(f + apart)) / (h * h);
    const double up = a.z / 9.81 + 1, along = std::hypot(a.x, a.y) / 9.81;
    out.pull = std::max(out.pull, -up);
    out.friction += std::pow(std::max(0.0, along - mu * std::max(0.0, up)), 2);
    bool flies = true;
    for (int k = f - apart; k <= f + apart; ++k) flies = flies && !touches(k);
    if (!flies) continue;
    out.flight += up * up + along * along;
    ++free;
  }
  out.friction = std::sqrt(out.friction / count);
  out.flight = std::sqrt(out.flight / std::max(1, free));
  return out;
}

/// rad: angle by which the hips have turned forwards at the end.
double turned(const Mechanism& m, const Motion& motion) {
  double sum = 0, before = 0;
  std::vector<Pose> X(m.links().size());
  for (int f = 0; f < motion.frames; ++f) {
    calc_poses(m, std::span(motion.frame(f), static_cast<std::size_t>(motion.nq)), X);
    const Vec3 up = X[0].R * Vec3{0, 0, 1};
    const double now = std::atan2(up.x, up.z);
    if (f > 0) sum += std::remainder(now - before, 2 * pi);
    before = now;
  }
  return sum;
}

TEST(Rehearse, AKeyedRollBecomesPhysical) {
  const MechanismPtr person = samples::make_person(1.75).value();
  const Motion keys = keyed_roll(*person);
  RehearseReport report;
  const Result<Motion> roll = rehearse_motion(person, keys, {.samples = 360}, &report);
  ASSERT_TRUE(roll) << roll.error().text();
  EXPECT_GT(report.assist_bw, 0.2) << "the keys need a force at the root";
  EXPECT_NEAR(turned(*person, *roll), 4.8, 0.6) << "rad: rolls onto the back";
  EXPECT_LT(report.change_deg, 15);
  for (int f = 0; f < roll->frames; ++f)
    ASSERT_GT(lowest_point(*person, std::span(roll->frame(f), static_cast<std::size_t>(roll->nq))), -0.01) << "m, frame " << f;
  const Forces before = forces_of(person, keys, 0.9), after = forces_of(person, *roll, 0.9);
  EXPECT_GT(before.pull, 0.5) << "body weights: the keys pull the body down";
  EXPECT_LT(after.friction, 0.03) << "body weights";
  EXPECT_LT(after.pull, 0.05) << "body weights";
  EXPECT_LT(after.flight, 0.1) << "body weights";
}

// From hands and feet to standing: the hands leave the floor when the centre of mass is above the soles.
TEST(Rehearse, AKeyedGetUpBecomesPhysical) {
  const MechanismPtr person = samples::make_person(1.75).value();
  const Motion keys = keyed_get_up(*person);
  RehearseReport report;
  const Result<Motion> up = rehearse_motion(person, keys, {.samples = 60, .kept = 10}, &report);
  ASSERT_TRUE(up) << up.error().text();
  EXPECT_LT(report.change_deg, 3);
  EXPECT_LT(report.root_move_cm, 3);
  EXPECT_GT(up->frame(up->frames - 1)[2], keys.frame(0)[2] + 0.2) << "m: stands";
  const Forces after = forces_of(person, *up, 0.9);
  EXPECT_LT(after.friction, 0.03) << "body weights";
  EXPECT_LT(after.pull, 0.05) << "body weights";
}

TEST(Rehearse, HasTheSameBitsTwice) {
  const MechanismPtr person = samples::make_person(1.75).value();
  Motion keys = keyed_roll(*person);
  keys.frames = 31;
  keys.q.resize(static_cast<std::size_t>(keys.nq) * 31);
  const RehearseOptions few{.samples = 30, .kept = 5};
  const Result<Motion> a = rehearse_motion(person, keys, few), b = rehearse_motion(person, keys, few);
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->q, b->q);
}

TEST(Rehearse, ReportsWhereTheMotionIsLost) {
  const MechanismPtr person = samples::make_person(1.75).value();
  Motion keys = keyed_roll(*person);
  for (int f = 30; f < keys.frames; ++f) keys.frame(f)[2] += 0.8;  // the body hovers
  RehearseReport report;
  const Result<Motion> lost = rehearse_motion(person, keys, {.samples = 30, .kept = 5}, &report);
  ASSERT_FALSE(lost);
  EXPECT_NE(lost.error().text().find("loses the motion after 0."), std::string::npos) << lost.error().text();
  EXPECT_FALSE(rehearse_motion(person, keys, {.samples = 3, .kept = 5}));
}

}  // namespace
}  // namespace ugoki::correction
