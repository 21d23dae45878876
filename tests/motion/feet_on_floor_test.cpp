#include "ugoki/motion/feet_on_floor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "ugoki/mechanism/state.h"

namespace ugoki {
namespace {

constexpr double sole = 0.93;  // m, depth of the sole below the hips with straight legs

/// A trunk on two legs with knees; feet are boxes.
MechanismPtr walker() {
  MechanismSpec spec;
  spec.name = "walker";
  const auto add = [&](const std::string& name, const std::string& parent, JointType type, const Vec3& at, const Shape& shape) {
    LinkSpec l;
    l.name = name;
    l.label = name.starts_with("foot") ? name : "";
    l.parent = parent;
    l.joint.type = type;
    l.joint.axis = {0, 1, 0};
    l.joint.X_PJ.p = at;
    l.inertia = solid_inertia(shape, 1000);
    l.shapes.push_back(shape);
    spec.links.push_back(l);
  };
  add("trunk", "", JointType::floating, {}, Shape::box({0.1, 0.15, 0.3}, {Mat3::identity(), {0, 0, 0.3}}));
  for (const double side : {-1.0, 1.0}) {
    const std::string s = side < 0 ? " right" : " left";
    add("thigh" + s, "trunk", JointType::spherical, {0, 0.1 * side, 0}, Shape::capsule(0.06, {0, 0, -0.05}, {0, 0, -0.4}));
    add("shank" + s, "thigh" + s, JointType::revolute, {0, 0, -0.43}, Shape::capsule(0.05, {0, 0, -0.05}, {0, 0, -0.4}));
    add("foot" + s, "shank" + s, JointType::spherical, {0, 0, -0.43}, Shape::box({0.12, 0.05, 0.03}, {Mat3::identity(), {0.05, 0, -0.04}}));
  }
  return Mechanism::make(std::move(spec)).value();
}

/// Sets q from the knee angles [rad] (right, left) and the root's height [m]; hips and ankles keep the feet level.
void pose(const Mechanism& m, double right, double left, double height, double* q) {
  const std::vector<double> neutral = m.neutral();
  std::copy(neutral.begin(), neutral.end(), q);
  q[2] = height;
  int side = 0;
  for (const double knee : {right, left}) {
    const Quat half = exp_map({0, -0.5 * knee, 0});
    double* leg = q + 7 + 9 * side++;
    for (const int at : {0, 5}) {
      leg[at] = half.w;
      leg[at + 2] = half.y;
    }
    leg[4] = knee;
  }
}

double lowest(const Mechanism& m, std::span<const double> q, const std::string& foot) {
  std::vector<Pose> X(static_cast<std::size_t>(m.link_count()));
  calc_poses(m, q, X);
  const auto i = static_cast<std::size_t>(m.find_link(foot));
  const Shape& s = m.links()[i].shapes[0];
  double low = 1e300;
  for (int c = 0; c < 8; ++c) {
    const Vec3 e{c & 1 ? 1.0 : -1.0, c & 2 ? 1.0 : -1.0, c & 4 ? 1.0 : -1.0};
    low = std::min(low, (X[i] * (s.X_BS * Vec3{e.x * s.half_extents.x, e.y * s.half_extents.y, e.z * s.half_extents.z})).z);
  }
  return low;
}

double leg_length(double knee) { return 0.86 * std::cos(0.5 * knee) + 0.07; }

Motion standing(const Mechanism& m, int frames) {
  Motion motion;
  motion.rate = 120;
  motion.frames = frames;
  motion.nq = m.nq();
  motion.q.resize(static_cast<std::size_t>(frames * m.nq()));
  return motion;
}

TEST(FeetOnFloor, TestPoseHasTheExpectedSoleHeights) {
  const MechanismPtr m = walker();
  std::vector<double> q(static_cast<std::size_t>(m->nq()));
  pose(*m, 0.6, 0, sole, q.data());
  EXPECT_NEAR(lowest(*m, q, "foot left"), 0, 1e-12);
  EXPECT_NEAR(lowest(*m, q, "foot right"), sole - leg_length(0.6), 1e-12);
}

TEST(FeetOnFloor, FeetOnTheFloorAreNotChanged) {
  const MechanismPtr m = walker();
  Motion motion = standing(*m, 40);
  for (int f = 0; f < motion.frames; ++f) pose(*m, 0.5, 0.5, leg_length(0.5), motion.frame(f));
  const Motion out = with_feet_on_floor(motion, *m, 0);
  for (std::size_t i = 0; i < out.q.size(); ++i) EXPECT_NEAR(out.q[i], motion.q[i], 1e-9);
}

TEST(FeetOnFloor, FeetBelowTheFloorAreRaisedAndStayLevel) {
  const MechanismPtr m = walker();
  Motion motion = standing(*m, 60);
  for (int f = 0; f < motion.frames; ++f) {
    pose(*m, 0.6, 0.5, leg_length(0.5) - 0.02, motion.frame(f));  // left foot 20 mm below the floor, right foot less deep
    for (int k = 0; k < 3; ++k) motion.frame(f)[k] += k == 2 ? 0.1 : 0.0;
  }
  const Motion out = with_feet_on_floor(motion, *m, 0.1);
  for (int f = 0; f < out.frames; ++f) {
    const std::span<const double> q(out.frame(f), static_cast<std::size_t>(m->nq()));
    EXPECT_NEAR(lowest(*m, q, "foot left"), 0.1, 1e-3) << f;
    EXPECT_NEAR(lowest(*m, q, "foot right"), 0.1, 1e-3) << f;
    std::vector<Pose> X(static_cast<std::size_t>(m->link_count()));
    calc_poses(*m, q, X);
    for (const char* foot : {"foot left", "foot right"})
      EXPECT_GT(X[static_cast<std::size_t>(m->find_link(foot))].R.zz, std::cos(0.005)) << f;
    EXPECT_EQ(out.frame(f)[0], motion.frame(f)[0]);
  }
}

TEST(FeetOnFloor, SwingingFootKeepsItsHeightAndStaysAboveTheFloor) {
  const MechanismPtr m = walker();
  Motion motion = standing(*m, 120);
  for (int f = 0; f < motion.frames; ++f) {  // the right foot is lifted once between frames 30 and 90
    const double s = f < 30 || f > 90 ? 0 : std::sin((f - 30) / 60.0 * 3.14159265358979);
    pose(*m, 0.3 + 0.9 * s * s, 0.3, leg_length(0.3) - 0.015, motion.frame(f));
  }
  const Motion out = with_feet_on_floor(motion, *m, 0);
  for (int f = 0; f < out.frames; ++f) {
    const std::span<const double> q(out.frame(f), static_cast<std::size_t>(m->nq()));
    EXPECT_NEAR(lowest(*m, q, "foot left"), 0, 1e-3) << f;
    EXPECT_GT(lowest(*m, q, "foot right"), -1e-3) << f;
  }
  const auto at = [&](const Motion& x) { return std::span<const double>(x.frame(60), static_cast<std::size_t>(m->nq())); };
  EXPECT_NEAR(lowest(*m, at(out), "foot right"), lowest(*m, at(motion), "foot right") + 0.015, 2e-3);
}

// The right foot turns its toes into the floor while its ankle stays at the height of standing.
TEST(FeetOnFloor, SunkenToesTurnTheFootInsteadOfLiftingTheLeg) {
  const MechanismPtr m = walker();
  Motion motion = standing(*m, 120);
  constexpr double pitch = 0.9;  // rad; the toes sink by 0.12 m
  for (int f = 0; f < motion.frames; ++f) {
    pose(*m, 0.3, 0.3, leg_length(0.3), motion.frame(f));
    const double s = f < 70 || f > 110 ? 0 : std::sin((f - 70) / 40.0 * 3.14159265358979);
    double* ankle = motion.frame(f) + 7 + 5;  // of the right leg
    const Quat turned = Quat{ankle[0], ankle[1], ankle[2], ankle[3]} * axis_angle({0, 1, 0}, pitch * s);
    ankle[0] = turned.w, ankle[1] = turned.x, ankle[2] = turned.y, ankle[3] = turned.z;
  }
  ASSERT_LT(lowest(*m, std::span(motion.frame(90), static_cast<std::size_t>(m->nq())), "foot right"), -0.1);
  const Motion out = with_feet_on_floor(motion, *m, 0);
  std::vector<Pose> before(static_cast<std::size_t>(m->link_count())), after = before;
  const auto foot = static_cast<std::size_t>(m->find_link("foot right"));
  for (int f = 0; f < out.frames; ++f) {
    const std::span<const double> q(out.frame(f), static_cast<std::size_t>(m->nq()));
    EXPECT_GT(lowest(*m, q, "foot right"), -2e-3) << f;
    calc_poses(*m, {motion.frame(f), q.size()}, before);
    calc_poses(*m, q, after);
    EXPECT_LT(after[foot].p.z - before[foot].p.z, 0.03) << f;  // lifted by 0.12 m without the turn
  }
}

}  // namespace
}  // namespace ugoki
