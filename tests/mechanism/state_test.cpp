#include "ugoki/mechanism/state.h"

#include <gtest/gtest.h>

#include <limits>

#include "random_joints.h"
#include "ugoki/motion/motion.h"

namespace ugoki {
namespace {

using test::Random;

/// A random tree of 18 links that contains every joint type twice.
MechanismPtr random_tree(Random& random) {
  MechanismSpec spec{"random", {}};
  for (int i = 0; i < 18; ++i) {
    LinkSpec l;
    l.name = "l" + std::to_string(i);
    l.parent = i == 0 ? "" : "l" + std::to_string(random.below(i));
    l.joint = random.joint(test::all_joint_types[static_cast<std::size_t>((i + 8) % 9)]);
    l.inertia = Inertia::from_centre(random.in(0.5, 3), random.vec(), {1, 1, 1, 0, 0, 0});
    spec.links.push_back(std::move(l));
  }
  auto m = Mechanism::make(std::move(spec));
  return m ? *m : nullptr;
}

std::vector<double> random_q(const Mechanism& m, Random& random) {
  std::vector<double> q(static_cast<std::size_t>(m.nq()));
  for (const Link& l : m.links()) random.coordinates(l.joint, q.data() + l.q_index);
  return q;
}
std::vector<double> random_v(const Mechanism& m, Random& random) {
  std::vector<double> v(static_cast<std::size_t>(m.nv()));
  for (double& x : v) x = random.in(-1, 1);
  return v;
}
std::vector<Pose> poses(const Mechanism& m, const std::vector<double>& q) {
  std::vector<Pose> X(static_cast<std::size_t>(m.link_count()));
  calc_poses(m, q, X);
  return X;
}
double difference(const Pose& a, const Pose& b) {
  const Mat3 e = a.R - b.R;
  return norm(e.row(0)) + norm(e.row(1)) + norm(e.row(2)) + norm(a.p - b.p);
}

TEST(State, StartsNeutralAtRest) {
  Random random;
  const MechanismPtr m = random_tree(random);
  ASSERT_NE(m, nullptr);
  const State s(*m);
  EXPECT_EQ(s.q, m->neutral());
  EXPECT_EQ(s.v.size(), static_cast<std::size_t>(m->nv()));
  EXPECT_EQ(s.tau.size(), s.v.size());
  EXPECT_EQ(s.external.size(), static_cast<std::size_t>(m->link_count()));
  for (const double x : s.v) EXPECT_EQ(x, 0);
}

TEST(State, PosesChainFromTheRoot) {
  Random random;
  const MechanismPtr m = random_tree(random);
  const std::vector<double> q = random_q(*m, random);
  const std::vector<Pose> X = poses(*m, q);
  for (int i = 0; i < m->link_count(); ++i) {
    Pose expected;
    for (int k = i; k >= 0; k = m->link(k).parent)
      expected = m->link(k).joint.X_PJ * joint_pose(m->link(k).joint, q.data() + m->link(k).q_index) * expected;
    EXPECT_LT(difference(X[static_cast<std::size_t>(i)], expected), 1e-13);
  }
}

TEST(State, VelocitiesAreTheDerivativeOfPoses) {
  Random random;
  for (int trial = 0; trial < 10; ++trial) {
    const MechanismPtr m = random_tree(random);
    const std::vector<double> q = random_q(*m, random), v = random_v(*m, random);
    std::vector<double> before(q.size()), after(q.size());
    const double dt = 1e-6;
    integrate(*m, q, v, -dt, before);
    integrate(*m, q, v, dt, after);
    const std::vector<Pose> X0 = poses(*m, before), X = poses(*m, q), X1 = poses(*m, after);
    std::vector<Vec6> V(X.size());
    calc_velocities(*m, q, v, V);
    for (std::size_t i = 0; i < X.size(); ++i) {
      const Mat3 spin = X[i].R.transposed() * ((X1[i].R - X0[i].R) * (0.5 / dt));
      const Vec3 w = Vec3{spin.zy - spin.yz, spin.xz - spin.zx, spin.yx - spin.xy} * 0.5;
      EXPECT_LT(norm(V[i].w - w), 1e-7);
      EXPECT_LT(norm(X[i].R * V[i].v - (X1[i].p - X0[i].p) * (0.5 / dt)), 1e-7);
    }
  }
}

TEST(State, DifferenceAndIntegrateAreInverse) {
  Random random;
  const MechanismPtr m = random_tree(random);
  for (int trial = 0; trial < 50; ++trial) {
    const std::vector<double> q0 = random_q(*m, random), q1 = random_q(*m, random);
    std::vector<double> v(static_cast<std::size_t>(m->nv())), back(q0.size());
    difference(*m, q0, q1, v);
    integrate(*m, q0, v, 1, back);
    const std::vector<Pose> X = poses(*m, q1), Y = poses(*m, back);
    for (std::size_t i = 0; i < X.size(); ++i) ASSERT_LT(difference(X[i], Y[i]), 1e-11);
  }
}

TEST(State, InterpolationStartsAtQ0AndHalvesTheWay) {
  Random random;
  const MechanismPtr m = random_tree(random);
  const std::vector<double> q0 = random_q(*m, random), q1 = random_q(*m, random);
  std::vector<double> q(q0.size()), half(q0.size()), d0(static_cast<std::size_t>(m->nv())), d1(d0.size());
  interpolate(*m, q0, q1, 0, q);
  for (std::size_t i = 0; i < q.size(); ++i) EXPECT_NEAR(q[i], q0[i], 1e-15);
  interpolate(*m, q0, q1, 0.5, half);
  difference(*m, q0, half, d0);
  difference(*m, half, q1, d1);
  for (std::size_t i = 0; i < d0.size(); ++i) EXPECT_NEAR(d0[i], d1[i], 1e-12);  // s = 0.5 is half way between q0 and q1
}

TEST(State, CentreOfMass) {
  MechanismSpec spec{"two", {}};
  for (const char* name : {"a", "b"}) {
    LinkSpec l;
    l.name = name;
    l.joint.type = JointType::floating;
    l.joint.X_PJ.p = {name[0] == 'a' ? 0.0 : 4.0, 0, 0};
    l.inertia = Inertia::from_centre(name[0] == 'a' ? 1 : 3, {0, 0, 1}, {1, 1, 1, 0, 0, 0});
    spec.links.push_back(l);
  }
  const auto m = Mechanism::make(std::move(spec));
  ASSERT_TRUE(m.has_value());
  EXPECT_LT(norm(centre_of_mass(**m, poses(**m, (*m)->neutral())) - Vec3{3, 0, 1}), 1e-15);
}

TEST(State, IsFiniteDetectsNanAndInfinity) {
  const double good[] = {0, 1, -1e308}, bad[] = {0, std::numeric_limits<double>::quiet_NaN()},
               infinite[] = {std::numeric_limits<double>::infinity()};
  EXPECT_TRUE(is_finite(std::span<const double>(good)));
  EXPECT_FALSE(is_finite(std::span<const double>(bad)));
  EXPECT_FALSE(is_finite(std::span<const double>(infinite)));
}

class MotionOfATree : public testing::Test {
 protected:
  void SetUp() override {
    mechanism = random_tree(random);
    motion.name = "m";
    motion.rate = 10;
    motion.frames = 5;
    motion.nq = mechanism->nq();
    for (int f = 0; f < 5; ++f) {
      const std::vector<double> q = random_q(*mechanism, random);
      motion.q.insert(motion.q.end(), q.begin(), q.end());
    }
  }
  std::vector<double> at(double t) {
    std::vector<double> q(static_cast<std::size_t>(mechanism->nq()));
    sample(motion, *mechanism, t, q);
    return q;
  }
  /// Largest difference of link poses. Poses do not depend on the sign of a quaternion.
  double apart(const std::vector<double>& a, const std::vector<double>& b) {
    const std::vector<Pose> X = poses(*mechanism, a), Y = poses(*mechanism, b);
    double worst = 0;
    for (std::size_t i = 0; i < X.size(); ++i) worst = std::max(worst, difference(X[i], Y[i]));
    return worst;
  }
  std::vector<double> frame(int f) { return {motion.frame(f), motion.frame(f) + motion.nq}; }

  Random random;
  MechanismPtr mechanism;
  Motion motion;
};

TEST_F(MotionOfATree, SampleEqualsFramesAndClampsAtTheEnds) {
  EXPECT_DOUBLE_EQ(motion.duration(), 0.4);
  for (int f = 0; f < 5; ++f) EXPECT_LT(apart(at(f * 0.1), frame(f)), 1e-11) << f;
  EXPECT_LT(apart(at(-1), frame(0)), 1e-12);
  EXPECT_LT(apart(at(100), frame(4)), 1e-11);
  EXPECT_LT(apart(at(0.4), frame(4)), 1e-11);
}

TEST_F(MotionOfATree, SampleIsContinuous) {
  for (double t = 0; t < 0.4; t += 0.0137) EXPECT_LT(apart(at(t), at(t + 1e-7)), 1e-3) << t;
}

TEST_F(MotionOfATree, OneFrameMotionIsAConstantPose) {
  motion.frames = 1;
  motion.q.resize(static_cast<std::size_t>(motion.nq));
  EXPECT_EQ(motion.duration(), 0);
  EXPECT_LT(apart(at(0), frame(0)), 1e-12);
  EXPECT_LT(apart(at(5), frame(0)), 1e-12);
}

TEST_F(MotionOfATree, UnusableMotionsAreReported) {
  EXPECT_TRUE(check_motion(motion, *mechanism).empty());
  const auto refused = [&](const Motion& m, const char* words) {
    const Error e = check_motion(m, *mechanism);
    EXPECT_NE(e.text().find(words), std::string::npos) << e.text();
  };
  Motion m = motion;
  m.nq = 3;
  refused(m, "coordinates");
  m = motion;
  m.q.pop_back();
  refused(m, "number of values");
  m = motion;
  m.frames = 0;
  refused(m, "no frames");
  m = motion;
  m.rate = 0;
  refused(m, "rate");
  m = motion;
  m.q[static_cast<std::size_t>(m.nq) * 2] = std::numeric_limits<double>::quiet_NaN();
  refused(m, "frame 2");
  m = motion;
  for (const Link& l : mechanism->links())
    if (l.joint.type == JointType::spherical) m.frame(3)[l.q_index] += 0.1;
  refused(m, "unit length");
  m = motion;
  m.contacts.push_back({"nobody", std::vector<std::uint8_t>(5)});
  refused(m, "'nobody'");
  m = motion;
  m.contacts.push_back({"l0", std::vector<std::uint8_t>(4)});
  refused(m, "contact labels");
}

}  // namespace
}  // namespace ugoki
