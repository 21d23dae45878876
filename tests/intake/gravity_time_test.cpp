// A jump of a person that is played too slowly or too fast gets the timing of free fall.

#include "ugoki/intake/gravity_time.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "ugoki/body/body.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/samples/samples.h"
#include "ugoki/spatial/rotation.h"

namespace ugoki::intake {
namespace {

constexpr double g = 9.81, apex = 0.3, min_bend = 0.4;  // m/s^2, m, rad: knees never straighten, so that the thighs do not jerk

std::size_t find(const MeasuredMotion& m, const std::string& name) {
  for (std::size_t i = 0; i < m.skeleton.joints.size(); ++i)
    if (m.skeleton.joints[i].name == name) return i;
  ADD_FAILURE() << name;
  return 0;
}

Quat about_y(double angle) { return {std::cos(0.5 * angle), 0, std::sin(0.5 * angle), 0}; }

/// A person stands, crouches, jumps 0.3 m high, lands in a crouch and stands. The legs push with 2 body weights. @param speed of playing
MeasuredMotion make_jump(double speed) {
  const MeasuredMotion stand = samples::make_human_stand();
  const std::size_t n = stand.skeleton.joints.size();
  MeasuredMotion out = stand;
  out.name = "jump";
  out.rate = 60;
  out.frames = static_cast<int>(4 / speed * out.rate);
  out.translations.clear();
  out.rotations.clear();
  const double v = std::sqrt(2 * g * apex), air = 2 * v / g, push = v / g, deepest = 0.5 * v * push;  // m/s, s, s, m
  for (int f = 0; f < out.frames; ++f) {
    const double t = f / out.rate * speed - 1.5, away = t <= 0 ? -t : t - air;  // s from take-off; s before it or after the landing
    double height = 0;
    if (t > 0 && t < air)
      height = v * t - 0.5 * g * t * t;
    else if (away < push)
      height = 0.5 * g * away * away - v * away;
    else
      height = -deepest * 0.5 * (1 + std::cos(3.14159265358979 * std::min(1.0, (away - push) / 0.8)));
    const auto from = [&](const auto& list) { return list.begin(); };
    out.translations.insert(out.translations.end(), from(stand.translations), from(stand.translations) + static_cast<std::ptrdiff_t>(n));
    out.rotations.insert(out.rotations.end(), from(stand.rotations), from(stand.rotations) + static_cast<std::ptrdiff_t>(n));
    const std::size_t at = static_cast<std::size_t>(f) * n;
    const double leg =
        norm(stand.skeleton.joints[find(stand, "LeftLeg")].offset) + norm(stand.skeleton.joints[find(stand, "LeftFoot")].offset);
    out.translations[at].z += height - leg * (1 - std::cos(min_bend));
    const double bend = std::acos(std::clamp(std::cos(min_bend) + std::min(0.0, height) / leg, -1.0, 1.0));
    for (const std::string side : {"Left", "Right"}) {
      for (const auto& [joint, turn] : {std::pair{"UpLeg", -bend}, std::pair{"Leg", 2 * bend}, std::pair{"Foot", -bend}}) {
        Quat& r = out.rotations[at + find(stand, side + joint)];
        r = r * about_y(turn);
      }
    }
  }
  return out;
}

/// Time in the air and height of the flight of the centre of mass. @return s, m
std::pair<double, double> flight_of(const body::Body& body, const MeasuredMotion& measured) {
  const Motion motion = body::to_motion(body, measured);
  std::vector<Pose> X(static_cast<std::size_t>(body.mechanism->link_count()));
  std::vector<double> height;
  for (int f = 0; f < motion.frames; ++f) {
    calc_poses(*body.mechanism, {motion.frame(f), static_cast<std::size_t>(motion.nq)}, X);
    height.push_back(centre_of_mass(*body.mechanism, X).z);
  }
  const double top = *std::ranges::max_element(height), take_off = top - apex;
  double first = 0, last = 0;
  for (std::size_t f = 1; f < height.size(); ++f) {  // crossings of the height at which the body takes off
    const double at = (static_cast<double>(f) - 1 + (take_off + 0.05 - height[f - 1]) / (height[f] - height[f - 1])) / motion.rate;
    if (height[f - 1] < take_off + 0.05 && height[f] >= take_off + 0.05) first = at;
    if (height[f - 1] >= take_off + 0.05 && height[f] < take_off + 0.05) last = at;
  }
  return {last - first, top - height.front()};
}

TEST(GravityTime, AJumpTakesTheTimeOfFreeFall) {
  const double expected = 2 * std::sqrt(2 * (apex - 0.05) / g);  // s above a height of 0.05 m over the take-off
  for (const double speed : {0.6, 1.7}) {
    MeasuredMotion jump = make_jump(speed);
    const Result<body::Body> body = body::make_body(jump);
    ASSERT_TRUE(body) << body.error().text();
    EXPECT_NEAR(flight_of(*body, jump).first, expected / speed, 0.02) << "the given jump";
    const double height = flight_of(*body, jump).second;
    const std::string sentence = retime_to_gravity(jump, *body->mechanism, body::to_motion(*body, jump), body->height);
    EXPECT_NE(sentence.find("jump: flights did not suit gravity"), std::string::npos) << sentence;
    EXPECT_NEAR(flight_of(*body, jump).first, expected, 0.06 * expected) << speed;
    EXPECT_NEAR(flight_of(*body, jump).second, height, 0.02) << "the jump stays as high";
  }
  // A physical jump and a walk stay as they are.
  MeasuredMotion right = make_jump(1), walk = samples::make_human_walk();
  for (MeasuredMotion* m : {&right, &walk}) {
    const MeasuredMotion before = *m;
    const Result<body::Body> body = body::make_body(*m);
    ASSERT_TRUE(body);
    EXPECT_EQ(retime_to_gravity(*m, *body->mechanism, body::to_motion(*body, *m), body->height), "");
    EXPECT_EQ(m->frames, before.frames);
  }
}

}  // namespace
}  // namespace ugoki::intake
