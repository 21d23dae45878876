// No body passes through another, however fast, thin or free to move: balls and plates, several plates, blades.

#include <gtest/gtest.h>

#include <cmath>

#include "fast.h"

namespace ugoki::contact {
namespace {

/// Side of plate `plate` on which body `s` is: -1 or 1; 0 if the body is beyond the plate's edges.
int side_of(Fast& f, std::size_t s, std::size_t plate, double half) {
  const Vec3 at = f.pose(plate).inverse() * f.pose(s).p;
  if (std::max(std::fabs(at.y), std::fabs(at.z)) > half) return 0;
  return at.x < 0 ? -1 : 1;
}

int balls_through_free_plates(std::span<const double> speeds, std::span<const double> thick, std::span<const double> steps, int& cases,
                              int& checked) {
  int passed = 0;
  for (const double speed : speeds)
    for (const double t : thick)
      for (const double dt : steps)
        for (const double radius : {0.002, 0.02, 0.05})
          for (const double e : {0.0, 0.5, 1.0})
            for (const double slant : {0.0, 0.7})
              for (const double spin : {0.0, 30.0}) {
                Shape ball = Shape::sphere(radius), sheet = Shape::box({t / 2, 0.5, 0.5});
                ball.restitution = sheet.restitution = e;
                Fast f({body("ball", ball, 8000), body("plate", sheet, 7800)});
                const Vec3 direction{std::cos(slant), 0.6 * std::sin(slant), 0.8 * std::sin(slant)};
                put(f.w.states[0], Vec3{-t / 2 - radius, 0.1, -0.07} - direction * (0.8 * std::max(1.0, spin == 0 ? 1.0 : speed * 1e-4)));
                for (int k = 0; k < 3; ++k) f.w.states[0].v[static_cast<std::size_t>(3 + k)] = speed * direction[k];
                f.w.states[1].v[1] = spin;
                ++cases;
                int side = -1;
                for (int k = 0; k < std::max(4, static_cast<int>(0.02 / dt)); ++k) {
                  f.step(dt);
                  if (!f.turns_little(1, dt)) break;
                  ++checked;
                  const int now = side_of(f, 0, 1, 0.35);
                  if (now == 0) break;
                  if (now == side) continue;
                  ++passed;
                  ADD_FAILURE() << speed << " m/s, " << t << " m thick, dt " << dt << " radius " << radius << " e " << e << " slant "
                                << slant << " spin " << spin;
                  break;
                }
              }
  return passed;
}

TEST(Passage, BallsDoNotPassFreePlates) {
  int cases = 0, checked = 0;
  EXPECT_EQ(balls_through_free_plates(std::vector{300.0}, std::vector{0.005}, std::vector{1.0 / 60, 0.002, 0.001}, cases, checked), 0);
  EXPECT_EQ(balls_through_free_plates(std::vector{1000.0}, std::vector{0.001}, std::vector{1.0 / 60, 0.002}, cases, checked), 0);
  EXPECT_GT(checked, 4 * cases);
}
TEST(Slow_Passage, BallsDoNotPassFreePlates) {
  int cases = 0, checked = 0;
  EXPECT_EQ(balls_through_free_plates(std::vector{50.0, 300.0, 1000.0}, std::vector{0.001, 0.005, 0.02},
                                      std::vector{1.0 / 60, 1.0 / 240, 0.002, 0.001}, cases, checked),
            0);
  EXPECT_GT(checked, 4 * cases);
}

/// Shoots random rotating bodies at rotating plates from random directions. @return number of bodies that passed through a plate
int passages_of_random_bodies(int count, unsigned seed) {
  testing::RandomSource random(seed);
  int passed = 0;
  for (int i = 0; i < count; ++i) {
    const double r = random.uniform(0.005, 0.05), thick = random.uniform(0.001, 0.01), speed = random.uniform(20, 500);
    Shape shape = any_shape(random, r), sheet = Shape::box({thick / 2, 0.5, 0.5});
    shape.restitution = random.below(2) == 0 ? 0 : random.uniform(0, 1);
    const bool fixed = random.below(4) == 0;
    MechanismSpec wall = body("plate", sheet, random.uniform(500, 8000))->spec();
    if (fixed) wall.links[0].joint.type = JointType::fixed;
    Fast f({body("body", shape, random.uniform(500, 8000)), Mechanism::make(std::move(wall)).value()});
    const double steps[] = {1.0 / 60, 1.0 / 120, 0.002, 0.001}, dt = steps[random.below(4)];
    const double lean = random.uniform(-1, 1), turn = random.uniform(-3, 3);
    const Vec3 direction{std::cos(lean), std::sin(lean) * std::cos(turn), std::sin(lean) * std::sin(turn)};
    const Vec3 target{0, random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2)};
    put(f.w.states[0], target - direction * (0.25 + random.uniform(0, 0.2)));
    for (int k = 0; k < 3; ++k) {
      f.w.states[0].v[static_cast<std::size_t>(k)] = random.uniform(-50, 50);
      f.w.states[0].v[static_cast<std::size_t>(3 + k)] = speed * direction[k];
      if (!fixed) f.w.states[1].v[static_cast<std::size_t>(k)] = random.uniform(-3, 3);
    }
    const int side = side_of(f, 0, 1, 1);
    for (int k = 0; k < 6; ++k) {
      f.step(dt);
      if (!f.turns_little(1, dt)) break;
      const int now = side_of(f, 0, 1, 0.3);
      if (now == 0) break;
      if (now == side) continue;
      ++passed;
      ADD_FAILURE() << "body " << i << " of seed " << seed << " passed in step " << k << " of " << dt << " s, " << f.report.substeps
                    << " substeps";
      break;
    }
  }
  return passed;
}
TEST(Passage, RandomBodiesDoNotPassPlates) { EXPECT_EQ(passages_of_random_bodies(150, 1), 0); }
TEST(Slow_Passage, RandomBodiesDoNotPassPlates) { EXPECT_EQ(passages_of_random_bodies(4000, 2), 0); }

TEST(Passage, SwordsDoNotPassFreeBodies) {
  int passed = 0;
  for (const double speed : {20.0, 60.0, 150.0})
    for (const double dt : {1.0 / 60, 0.002})
      for (const double angle : {0.7, 1.3, 2.3})
        for (const double density : {100.0, 1000.0, 8000.0})
          for (int shape = 0; shape < 4; ++shape) {
            const Shape shapes[] = {Shape::cylinder(0.004, 0.3), Shape::sphere(0.03), Shape::box({0.2, 0.002, 0.2}),
                                    Shape::box({0.002, 0.1, 0.2})};
            Fast f({sword(0.001), body("target", shapes[shape], density)});
            put(f.w.states[1], {0.9 * std::cos(angle), 0.9 * std::sin(angle), 0});
            const Quat turn = exp_map({0, 0, angle});
            f.w.states[1].q[3] = turn.w;
            f.w.states[1].q[6] = turn.z;
            f.w.states[0].v[0] = speed;
            for (int k = 0; k < 60; ++k) {
              f.step(dt);
              // The body stays in front of the blade until it has flown away.
              const Vec3 at = f.pose(0).inverse() * f.pose(1).p;
              if (at.x < 0.15 || at.x > 1.25 || std::fabs(at.z) > 0.02) break;
              if (at.y < 0 && at.y > -0.5) {
                ++passed;
                ADD_FAILURE() << speed << " rad/s, dt " << dt << " angle " << angle << " density " << density << " shape " << shape;
                break;
              }
              if (at.y > 0.5) break;
            }
          }
  EXPECT_EQ(passed, 0);
}

TEST(Passage, BallDoesNotPassSeveralPlatesInARow) {
  for (const double dt : {1.0 / 60, 0.002, 0.001})
    for (const double gap : {0.006, 0.05, 0.3})
      for (const double e : {0.0, 1.0}) {
        Shape ball = Shape::sphere(0.02), sheet = Shape::box({0.0025, 0.5, 0.5});
        ball.restitution = sheet.restitution = e;
        std::vector<MechanismPtr> bodies = {body("ball", ball, 8000)};
        for (int i = 0; i < 4; ++i) bodies.push_back(body("plate", sheet, 7800));
        Fast f(bodies);
        put(f.w.states[0], {-0.9, 0.02, 0.01});
        f.w.states[0].v[3] = 300;
        for (std::size_t i = 1; i < 5; ++i) f.w.states[i].q[0] = gap * static_cast<double>(i - 1);
        for (int k = 0; k < std::max(4, static_cast<int>(0.02 / dt)); ++k) {
          f.step(dt);
          EXPECT_LE(side_of(f, 0, 1, 0.35), 0) << "dt " << dt << " gap " << gap << " e " << e << " step " << k;
          for (std::size_t i = 1; i < 4; ++i)
            EXPECT_LE(side_of(f, i, i + 1, 0.2), 0) << "plate " << i << " dt " << dt << " gap " << gap << " e " << e << " step " << k;
          if (::testing::Test::HasFailure()) return;
        }
      }
}

}  // namespace
}  // namespace ugoki::contact
