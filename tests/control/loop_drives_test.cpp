#include "ugoki/control/loop_drives.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "ugoki/dynamics/closed_links.h"
#include "ugoki/dynamics/closed_reference.h"
#include "ugoki/dynamics/dynamics.h"

namespace ugoki::control {
namespace {

constexpr Vec3 gravity{0, 0, -9.81};

/// Two legs of three links in the plane x-z turn one crank with pedals at its ends, as on a bicycle. All joints are hinges about y.
MechanismPtr pedals() {
  MechanismSpec spec;
  spec.name = "pedals";
  const auto add = [&](const std::string& name, const std::string& parent, const Vec3& at, const Vec3& end, double turn) {
    LinkSpec l;
    l.name = name;
    l.parent = parent;
    l.joint.type = parent.empty() ? JointType::fixed : JointType::revolute;
    l.joint.axis = {0, 1, 0};
    l.joint.X_PJ = {rotation_about({0, 1, 0}, turn), at};
    const Shape shape = Shape::capsule(0.05, {}, end);
    l.inertia = solid_inertia(shape, 1000);
    spec.links.push_back(l);
  };
  add("frame", "", {}, {0, 0, 1}, 0);
  add("crank", "frame", {0, 0, 0.3}, {0.17, 0, 0}, 0);
  for (const double side : {1.0, -1.0}) {
    const std::string s = side > 0 ? " left" : " right";
    add("thigh" + s, "frame", {-0.2, 0.1 * side, 1.05}, {0, 0, -0.45}, -1.0);
    add("shank" + s, "thigh" + s, {0, 0, -0.45}, {0, 0, -0.45}, 1.0);
    add("foot" + s, "shank" + s, {0, 0, -0.45}, {0.15, 0, 0}, 0.1);
    LoopSpec loop;
    loop.name = "pedal" + s;
    loop.type = LoopType::revolute;
    loop.axis = {0, 1, 0};
    loop.link_a = "foot" + s;
    loop.link_b = "crank";
    loop.X_AJ.p = {0.12, 0, 0};
    loop.X_BJ.p = {0.17 * side, 0.1 * side, 0};
    spec.loops.push_back(loop);
  }
  for (LinkSpec& l : spec.links)
    if (l.name == "crank") l.joint.dofs[0].armature = 2;  // kg m^2: a wheel that it turns
  for (LinkSpec& l : spec.links)
    if (l.name != "frame") l.joint.dofs[0].effort = l.name == "crank" ? 0 : l.name.starts_with("foot") ? 50 : 150;
  return Mechanism::make(std::move(spec)).value();
}

struct Pedalling {
  MechanismPtr m = pedals();
  std::size_t n = static_cast<std::size_t>(m->nv());
  dynamics::Workspace ws{*m};
  dynamics::ClosedLinks closed{*m};
  std::vector<double> q = m->neutral(), v = std::vector<double>(n), strength = v, wanted = v, tau = v;

  Pedalling() {
    for (std::size_t i = 0; i < n; ++i) strength[i] = m->dof(static_cast<int>(i)).effort;
    double gap = 0;
    EXPECT_EQ(dynamics::project_position(*m, ws, closed, q, v, gap), dynamics::ClosedStatus::ok);
    EXPECT_LT(gap, 1e-9);
    std::mt19937 random(7);
    std::uniform_real_distribution<double> any(-1, 1);
    for (double& x : v) x = 4 * any(random);
    dynamics::update_kinematics(*m, q, v, ws);
    EXPECT_EQ(dynamics::factor_closed_links(*m, ws, closed, q, v), dynamics::ClosedStatus::ok);
    dynamics::project_velocity(*m, ws, closed, v);
    // accelerations that the loops permit: those under any torques
    std::vector<double> some(n);
    for (double& x : some) x = 40 * any(random);
    EXPECT_EQ(dynamics::calc_closed_forward_dynamics(*m, closed, q, v, some, gravity, {}, wanted), dynamics::ClosedStatus::ok);
    dynamics::update_kinematics(*m, q, v, ws);
    dynamics::calc_inverse_dynamics(*m, ws, wanted, gravity, {}, tau);
  }
  [[nodiscard]] std::size_t crank() const { return static_cast<std::size_t>(m->link(m->find_link("crank")).v_index); }
};

TEST(LoopDrives, TorquesGiveTheWantedMotionWithoutADriveOfTheCrank) {
  Pedalling p;
  EXPECT_GT(std::fabs(p.tau[p.crank()]), 1) << "N m: the tree needs a torque at the crank";
  LoopDrives drives(*p.m, p.strength);
  ASSERT_TRUE(drives.contains(static_cast<int>(p.crank())));
  drives.distribute(*p.m, p.ws, p.q, p.v, p.tau);
  EXPECT_NEAR(p.tau[p.crank()], 0, 1e-3);
  p.tau[p.crank()] = 0;
  std::vector<double> vdot(p.n);
  ASSERT_EQ(dynamics::calc_closed_forward_dynamics(*p.m, p.closed, p.q, p.v, p.tau, gravity, {}, vdot), dynamics::ClosedStatus::ok);
  for (std::size_t i = 0; i < p.n; ++i) EXPECT_NEAR(vdot[i], p.wanted[i], 1e-3 * (1 + std::fabs(p.wanted[i]))) << i;
}

// The method of Nagashima (1999), eq. (4), computes the same torques from the independent coordinates.
TEST(LoopDrives, RedundantTorquesAreThoseOfTheClosedInverseDynamics) {
  Pedalling p;
  dynamics::ClosedWorkspace cw(*p.m);
  dynamics::update_closed(*p.m, p.q, p.v, cw);
  std::vector<int> driven;
  std::vector<double> weights, tau(p.n);
  for (std::size_t i = 0; i < p.n; ++i)
    if (p.strength[i] > 0) {
      driven.push_back(static_cast<int>(i));
      weights.push_back(1 / (p.strength[i] * p.strength[i]));
    }
  ASSERT_TRUE(dynamics::calc_closed_inverse_dynamics(*p.m, cw, p.wanted, gravity, {}, {}, driven, weights, tau));
  LoopDrives(*p.m, p.strength).distribute(*p.m, p.ws, p.q, p.v, p.tau);
  for (std::size_t i = 0; i < p.n; ++i) EXPECT_NEAR(p.tau[i], tau[i], 1e-3 * (1 + std::fabs(tau[i]))) << i;
}

TEST(LoopDrives, DoNothingWithoutLoops) {
  MechanismSpec spec = pedals()->spec();
  spec.loops.clear();
  const MechanismPtr m = Mechanism::make(std::move(spec)).value();
  EXPECT_TRUE(LoopDrives(*m, std::vector<double>(static_cast<std::size_t>(m->nv()), 1.0)).empty());
}

}  // namespace
}  // namespace ugoki::control
