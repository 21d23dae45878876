#include "ugoki/motion/smooth_motion.h"

#include <gtest/gtest.h>

#include <cmath>

#include "ugoki/mechanism/state.h"

namespace ugoki {
namespace {

/// A floating link, a second link attached to it by a ball joint, and a third link attached to the second by a hinge.
MechanismPtr character() {
  MechanismSpec spec;
  spec.name = "character";
  const auto add = [&](const std::string& name, const std::string& parent, JointType type) {
    LinkSpec l;
    l.name = name;
    l.parent = parent;
    l.joint.type = type;
    l.joint.axis = {0, 1, 0};
    l.inertia = Inertia::from_centre(1, {0, 0, 0.1}, {0.01, 0.01, 0.01, 0, 0, 0});
    spec.links.push_back(l);
  };
  add("root", "", JointType::floating);
  add("ball", "root", JointType::spherical);
  add("hinge", "ball", JointType::revolute);
  return Mechanism::make(std::move(spec)).value();
}

/// Coordinates at time t [s]: the root rotates about a slanted axis and translates, the ball joint rotates, the hinge swings; all smooth.
void truth(double t, double* q) {
  const Quat turn = exp_map(Vec3{0.3, -0.5, 0.8} * (0.9 * std::sin(2 * t)));
  const Quat ball = exp_map(Vec3{0.4 * std::sin(3 * t), 0.2, 0.3 * std::cos(2 * t)});
  const double values[] = {
      1.2 * t, 0.1 * std::sin(5 * t), 0.9 + 0.03 * std::cos(6 * t), turn.w, turn.x, turn.y, turn.z, ball.w, ball.x, ball.y,
      ball.z,  0.7 * std::sin(4 * t)};
  std::copy(std::begin(values), std::end(values), q);
}

Motion recorded(const Mechanism& m, double noise, bool flip_signs) {
  Motion motion;
  motion.name = "made";
  motion.mechanism = m.name();
  motion.rate = 120;
  motion.frames = 361;
  motion.nq = m.nq();
  motion.q.resize(static_cast<std::size_t>(motion.frames * motion.nq));
  std::uint64_t seed = 1;
  for (int f = 0; f < motion.frames; ++f) {
    truth(f / motion.rate, motion.frame(f));
    for (int k = 0; k < motion.nq; ++k) {
      seed = seed * 6364136223846793005ULL + 1442695040888963407ULL;
      motion.frame(f)[k] += noise * (static_cast<double>(seed >> 11) / 9007199254740992.0 - 0.5);
    }
    if (flip_signs && f % 3 == 1)
      for (int k = 3; k < 7; ++k) motion.frame(f)[k] *= -1;
  }
  return motion;
}

TEST(SmoothMotion, VelocityAndAccelerationAreDerivativesOfPosition) {
  const MechanismPtr m = character();
  const SmoothMotion smooth(recorded(*m, 0, true), *m, 0);
  std::vector<double> q(12), v(10), a(10), q0(12), q1(12), v0(10), v1(10), unused(10), d(10), exact(12);
  const double h = 1e-4;
  for (double t = 0.3; t < 2.7; t += 0.0137) {
    smooth.sample(*m, t, q, v, a);
    smooth.sample(*m, t - h, q0, v0, unused);
    smooth.sample(*m, t + h, q1, v1, unused);
    truth(t, exact.data());
    difference(*m, q, exact, d);
    for (const double x : d) EXPECT_LT(std::fabs(x), 2e-4) << t;
    difference(*m, q0, q1, d);
    for (std::size_t i = 0; i < 10; ++i) {
      EXPECT_NEAR(d[i] / (2 * h), v[i], 0.02) << "velocity " << i << " at " << t;
      EXPECT_NEAR((v1[i] - v0[i]) / (2 * h), a[i], 0.6) << "acceleration " << i << " at " << t;
    }
  }
}

TEST(SmoothMotion, FilterRemovesNoiseAndKeepsTheMotion) {
  const MechanismPtr m = character();
  const double noise = 0.004;
  const SmoothMotion raw(recorded(*m, noise, false), *m, 0), smooth(recorded(*m, noise, false), *m, 6),
      clean(recorded(*m, 0, false), *m, 0);
  std::vector<double> q(12), v(10), a(10), q_clean(12), v_clean(10), a_clean(10), d(10);
  double error_raw = 0, error_smooth = 0, moved = 0;
  for (double t = 0.1; t < 2.9; t += 0.01) {
    clean.sample(*m, t, q_clean, v_clean, a_clean);
    raw.sample(*m, t, q, v, a);
    for (std::size_t i = 0; i < 10; ++i) error_raw += (a[i] - a_clean[i]) * (a[i] - a_clean[i]);
    smooth.sample(*m, t, q, v, a);
    for (std::size_t i = 0; i < 10; ++i) error_smooth += (a[i] - a_clean[i]) * (a[i] - a_clean[i]);
    difference(*m, q, q_clean, d);
    for (const double x : d) moved = std::max(moved, std::fabs(x));
  }
  EXPECT_LT(error_smooth, error_raw / 100);
  EXPECT_LT(moved, 0.03);
}

/// A motion of the hinge alone: angle(t) [rad] at `rate` frames per second.
template <class Angle>
Motion hinge_only(const Mechanism& m, double rate, int frames, Angle angle) {
  Motion motion;
  motion.mechanism = m.name();
  motion.rate = rate;
  motion.frames = frames;
  motion.nq = m.nq();
  for (int f = 0; f < frames; ++f) {
    std::vector<double> q = m.neutral();
    q[11] = angle(f / rate);
    motion.q.insert(motion.q.end(), q.begin(), q.end());
  }
  return motion;
}

TEST(SmoothMotion, HalfThePowerPassesAtTheCutoff) {
  const MechanismPtr m = character();
  for (const double cutoff : {3.0, 6.0, 15.0}) {
    const SmoothMotion smooth(hinge_only(*m, 240, 961, [&](double t) { return std::sin(2 * pi * cutoff * t); }), *m, cutoff);
    std::vector<double> q(12), v(10), a(10);
    double maximum = 0;
    for (double t = 1.5; t < 2.5; t += 1 / 240.0) {
      smooth.sample(*m, t, q, v, a);
      maximum = std::max(maximum, std::fabs(q[11]));
    }
    EXPECT_NEAR(maximum, std::sqrt(0.5), 0.01) << cutoff << " Hz";
  }
}

TEST(SmoothMotion, SignsOfQuaternionsHaveNoEffect) {
  const MechanismPtr m = character();
  const SmoothMotion plain(recorded(*m, 0, false), *m, 6), flipped(recorded(*m, 0, true), *m, 6);
  std::vector<double> q(12), v(10), a(10), q2(12), d(10);
  for (double t = 0; t < 3; t += 0.1) {
    plain.sample(*m, t, q, v, a);
    flipped.sample(*m, t, q2, v, a);
    difference(*m, q, q2, d);
    for (const double x : d) EXPECT_LT(std::fabs(x), 1e-12) << t;
  }
}

TEST(SmoothMotion, CyclicMotionIsSmoothAcrossItsSeam) {
  const MechanismPtr m = character();
  const double w = 2 * pi;  // one cycle per second, advancing by 0.5 rad in each
  Motion motion = hinge_only(*m, 120, 121, [&](double t) { return 0.5 * t + 0.3 * std::cos(w * t); });
  motion.cyclic = true;
  const SmoothMotion smooth(motion, *m, 6);
  std::vector<double> q(12), v(10), a(10);
  for (const double t : {0.0, 0.01, 0.99}) {
    smooth.sample(*m, t, q, v, a);
    EXPECT_NEAR(q[11], 0.5 * t + 0.3 * std::cos(w * t), 0.002) << t;
    EXPECT_NEAR(v[9], 0.5 - 0.3 * w * std::sin(w * t), 0.02) << t;
    EXPECT_NEAR(a[9], -0.3 * w * w * std::cos(w * t), 0.3) << t;
  }
}

TEST(SmoothMotion, IsAtRestBeforeAndAfterTheMotion) {
  const MechanismPtr m = character();
  const SmoothMotion smooth(recorded(*m, 0, false), *m, 6);
  std::vector<double> q(12), v(10), a(10);
  for (const double t : {-1.0, 99.0}) {
    smooth.sample(*m, t, q, v, a);
    for (const double x : v) EXPECT_EQ(x, 0);
    for (const double x : a) EXPECT_EQ(x, 0);
    EXPECT_TRUE(is_finite(q));
  }
}

TEST(SmoothMotion, ClipPlacementAppliesToPositionAndVelocity) {
  const MechanismPtr m = character();
  const SmoothMotion smooth(recorded(*m, 0, false), *m, 0);
  Clip clip;
  clip.start = 1;
  clip.length = 1;
  clip.offset = 0.5;
  clip.speed = 1.5;
  clip.placement = {3, -2, 0, 0.8};
  std::vector<double> q(12), v(10), a(10), q0(12), q1(12), unused(10), d(10);
  const double h = 1e-4;
  for (double t = 1.1; t < 1.9; t += 0.07) {
    sample(clip, smooth, *m, t, q, v, a);
    sample(clip, smooth, *m, t - h, q0, unused, d);
    sample(clip, smooth, *m, t + h, q1, unused, d);
    difference(*m, q0, q1, d);
    for (std::size_t i = 0; i < 10; ++i) EXPECT_NEAR(d[i] / (2 * h), v[i], 0.03) << i << " at " << t;
  }
}

TEST(SmoothMotion, OneAndTwoFramesWork) {
  const MechanismPtr m = character();
  for (const int frames : {1, 2, 3}) {
    Motion motion = recorded(*m, 0, false);
    motion.frames = frames;
    motion.q.resize(static_cast<std::size_t>(frames * motion.nq));
    const SmoothMotion smooth(motion, *m, 6);
    std::vector<double> q(12), v(10), a(10);
    smooth.sample(*m, 0.004, q, v, a);
    EXPECT_TRUE(is_finite(q));
    EXPECT_TRUE(is_finite(v));
  }
}

}  // namespace
}  // namespace ugoki
