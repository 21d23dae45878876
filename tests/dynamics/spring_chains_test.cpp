#include "ugoki/dynamics/spring_chains.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "../mechanism/chain.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::dynamics {
namespace {

constexpr Vec3 gravity{0, 0, -9.81};

/// A fixed post and a chain of rods along `direction`, each 0.1 m long with a mass of 0.1 kg.
MechanismPtr chain(int rods, const Vec3& direction, JointType type = JointType::revolute) {
  return testing::make_chain(rods + 1, [&](int i, LinkSpec& link) {
    if (i == 0) {
      link.inertia = Inertia::from_centre(1, {}, {0.01, 0.01, 0.01, 0, 0, 0});
      return;
    }
    link.joint.type = type;
    link.joint.axis = {0, 1, 0};
    if (i > 1) link.joint.X_PJ.p = direction * 0.1;
    const double I = 0.1 * 0.1 * 0.1 / 12, small = 1e-5;
    const Vec3 d = direction;
    link.inertia = Inertia::from_centre(0.1, direction * 0.05,
                                        {I * (1 - d.x * d.x) + small, I * (1 - d.y * d.y) + small, I * (1 - d.z * d.z) + small,
                                         -I * d.x * d.y, -I * d.x * d.z, -I * d.y * d.z});
  });
}

/// Integrates the chain with its springs and dampers in small explicit steps (semi-implicit Euler, 20 us), which do not damp.
/// @return angle of the last joint [rad] every millisecond
std::vector<double> swing(const Mechanism& m, std::vector<double> q, double seconds) {
  constexpr double dt = 2e-5;
  Workspace ws(m);
  std::vector<double> v(static_cast<std::size_t>(m.nv()), 0.0), tau(v.size()), a(v.size()), x(v.size()), out;
  for (int step = 0; step < static_cast<int>(seconds / dt); ++step) {
    for (const Link& link : m.links()) joint_displacement(link.joint, q.data() + link.q_index, x.data() + link.v_index);
    if (step % 50 == 0) out.push_back(x.back());
    for (std::size_t i = 0; i < v.size(); ++i) {
      const Dof& d = m.dof(static_cast<int>(i));
      tau[i] = -d.stiffness * (x[i] - d.rest) - d.damping * v[i];
    }
    EXPECT_TRUE(calc_forward_dynamics(m, ws, q, v, tau, gravity, {}, a));
    for (std::size_t i = 0; i < v.size(); ++i) v[i] += dt * a[i];
    integrate(m, q, v, dt, q);
  }
  return out;
}

struct Ringing {
  double frequency = 0, damping = 0;  // Hz; damping ratio
};
/// Frequency and damping ratio of a decaying oscillation about zero, from its peaks (logarithmic decrement), after `skip` [ms].
Ringing measure(const std::vector<double>& x, std::size_t skip) {
  std::vector<double> time, size;
  for (std::size_t i = std::max<std::size_t>(skip, 1); i + 1 < x.size(); ++i)
    if (x[i] > x[i - 1] && x[i] >= x[i + 1] && x[i] > 1e-6) {
      const double bend = x[i - 1] - 2 * x[i] + x[i + 1], shift = 0.5 * (x[i - 1] - x[i + 1]) / bend;
      time.push_back(1e-3 * (static_cast<double>(i) + shift));
      size.push_back(x[i]);
    }
  if (time.size() < 3) return {};
  const double periods = static_cast<double>(time.size() - 1);
  const double decrement = std::log(size.front() / size.back()) / periods, z = decrement / std::sqrt(4 * pi * pi + decrement * decrement);
  return {periods / (time.back() - time.front()) / std::sqrt(1 - z * z), z};
}

TEST(SpringChains, OneRodHasTheStiffnessOfAnOscillator) {
  const MechanismPtr m = chain(1, {1, 0, 0});
  const auto sprung = with_spring_chains(*m, {{{1, 2.0, 0.1}}}, m->neutral(), gravity, 0);
  ASSERT_TRUE(sprung) << sprung.error().text();
  // Moment of inertia about the hinge: m l^2 / 3, plus 1e-5. The rod is horizontal, so gravity has no stiffness.
  const double I = 0.1 * 0.01 / 3 + 1e-5, w = 2 * pi * 2.0;
  const Dof& d = (*sprung)->dof(0);
  EXPECT_NEAR(d.stiffness, I * w * w, 1e-6 * d.stiffness);
  EXPECT_NEAR(d.damping, 2 * 0.1 * w * I, 1e-6 * d.damping);
  EXPECT_NEAR(d.stiffness * d.rest, -0.1 * 9.81 * 0.05, 1e-9) << "the preload carries the weight";
  EXPECT_EQ(d.effort, 0);
}

TEST(SpringChains, ChainsRingAtTheirFrequency) {
  for (const Vec3& direction : {Vec3{1, 0, 0}, Vec3{0, 0, -1}, Vec3{0, 0, 1}})
    for (const double frequency : {1.5, 4.0}) {
      const MechanismPtr m = chain(5, direction);
      const auto sprung = with_spring_chains(*m, {{{1, frequency, 0.1}}}, m->neutral(), gravity, 0);
      ASSERT_TRUE(sprung) << sprung.error().text();
      std::vector<double> q = m->neutral();
      for (double& angle : q) angle = 0.004;
      const Ringing rings = measure(swing(**sprung, q, 6 / frequency), static_cast<std::size_t>(1500 / frequency));
      EXPECT_NEAR(rings.frequency, frequency, 0.01 * frequency) << direction.x << " " << direction.z;
      EXPECT_NEAR(rings.damping, 0.1, 0.003) << direction.x << " " << direction.z << " " << frequency;
    }
}

TEST(SpringChains, GravityDoesNotBendTheRestPose) {
  const MechanismPtr m = chain(4, {1, 0, 0}, JointType::spherical);
  const auto sprung = with_spring_chains(*m, {{{1, 2.0, 0.2}}}, m->neutral(), gravity, 0);
  ASSERT_TRUE(sprung) << sprung.error().text();
  for (const double angle : swing(**sprung, m->neutral(), 1)) ASSERT_NEAR(angle, 0, 1e-9);
}

TEST(SpringChains, RefusesImpossibleChains) {
  const MechanismPtr m = chain(2, {0, 0, -1});
  const auto slow = with_spring_chains(*m, {{{1, 0.1, 0.1}}}, m->neutral(), gravity, 0);
  ASSERT_FALSE(slow);
  // A hanging rod of length l swings at sqrt(3 g / (2 l)) / 2 pi = 1.37 Hz for l = 0.2 m; the free second rod makes it a little slower.
  EXPECT_NE(slow.error().text().find("link link1: Under gravity alone, the chain swings at 1.3"), std::string::npos) << slow.error().text();
  EXPECT_FALSE(with_spring_chains(*m, {{{0, 2, 0.1}, {1, 2, 0.1}}}, m->neutral(), gravity, 0)) << "the second chain is part of the first";
  MechanismSpec spec;
  LinkSpec body;
  body.name = "body";
  body.joint.type = JointType::floating;
  body.inertia = Inertia::from_centre(1, {}, {1, 1, 1, 0, 0, 0});
  spec.links.push_back(body);
  const MechanismPtr ball = Mechanism::make(spec).value();
  EXPECT_FALSE(with_spring_chains(*ball, {{{0, 2, 0.1}}}, ball->neutral(), gravity, 0));
}

}  // namespace
}  // namespace ugoki::dynamics
