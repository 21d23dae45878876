#include "ugoki/control/motion_control.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "ugoki/collision/scene.h"
#include "ugoki/contact/stepper.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion/clip.h"

namespace ugoki::control {
namespace {

/// A trunk on two straight legs with box feet; hips and ankles are ball joints.
MechanismPtr biped() {
  MechanismSpec spec;
  spec.name = "biped";
  const auto add = [&](const std::string& name, const std::string& parent, JointType type, const Vec3& at, const Shape& shape,
                       double density) {
    LinkSpec l;
    l.name = name;
    l.parent = parent;
    l.joint.type = type;
    l.joint.X_PJ.p = at;
    l.inertia = solid_inertia(shape, density);
    l.shapes.push_back(shape);
    spec.links.push_back(l);
  };
  add("trunk", "", JointType::floating, {}, Shape::box({0.1, 0.15, 0.3}, {Mat3::identity(), {0, 0, 0.3}}), 1000);
  for (const double side : {-1.0, 1.0}) {
    const std::string s = side < 0 ? "right" : "left";
    add("leg " + s, "trunk", JointType::spherical, {0, 0.1 * side, 0}, Shape::capsule(0.06, {0, 0, -0.1}, {0, 0, -0.75}), 1000);
    add("foot " + s, "leg " + s, JointType::spherical, {0, 0, -0.85}, Shape::box({0.12, 0.05, 0.03}, {Mat3::identity(), {0.05, 0, -0.03}}),
        1000);
  }
  return Mechanism::make(std::move(spec)).value();
}

struct Simulation {
  MechanismPtr m = biped();
  collision::Scene scene{{m}};
  collision::Workspace workspace{scene};
  contact::Stepper stepper{{m}, {}};
  MotionControl control;
  ControlState memory;
  State state{*m};
  std::vector<Pose> X{static_cast<std::size_t>(m->link_count())};
  std::vector<collision::ContactPoint> contacts;
  std::vector<double> gain = std::vector<double>(static_cast<std::size_t>(m->nv())), target = gain;
  std::vector<double> reference = m->neutral(), rest = std::vector<double>(static_cast<std::size_t>(m->nv()));
  ControlOutput last;

  explicit Simulation(const ControlOptions& options = {}, const Placement& place = {0, 0, 0, 0}) : control(m, options) {
    reference[2] = 0.91;
    displace_root(*m, place, reference);
    state.q = reference;
  }
  void step(const Vec3& push) {
    calc_poses(*m, state.q, X);
    const std::span<const Pose> poses(X);
    collision::find_contacts(scene, std::span(&poses, 1), 0.02, workspace, contacts);
    last = control.step({state.q, state.v, reference, rest, rest, contacts, 0, 0.002}, memory, state.tau, gain, target);
    state.external[0] = MotionControl::about_world_origin(last.assist, X[0].p);
    const Vec3 chest = X[0] * Vec3{0, 0, 0.4};
    state.external[0] += Vec6{cross(chest, push), push};
    contact::StepSystem system{state.q, state.v, state.tau, state.external, gain, target};
    ASSERT_EQ(stepper.step(std::span(&system, 1), contacts, 0.002).status, contact::StepStatus::ok);
  }
};

TEST(MotionControl, StandsOnItsOwnFeet) {
  Simulation s;
  double worst = 0;
  for (int i = 0; i < 2000; ++i) {
    s.step({});
    if (i > 500) worst = std::max(worst, s.last.size_bw);
  }
  EXPECT_FALSE(s.last.released);
  EXPECT_LT(worst, 0.01);
  EXPECT_NEAR(s.state.q[2], 0.91, 0.005);
}

// Controllers of a mechanism do not affect each other.
TEST(MotionControl, OtherCharactersOfTheMechanismHaveNoEffect) {
  Simulation alone, one, other({}, {1, 2, 0, 0.5});
  other.m = one.m;
  other.control = MotionControl(one.m, {});
  other.state.q[2] += 0.2;  // falls onto its feet while the first character stands on them
  for (int i = 0; i < 300; ++i) {
    const Vec3 push = i < 100 ? Vec3{60, 0, 0} : Vec3{};
    alone.step(push);
    one.step(push);
    other.step({});
  }
  EXPECT_EQ(alone.state.q, one.state.q);
  EXPECT_EQ(alone.state.v, one.state.v);
}

TEST(MotionControl, RecoversFromAPush) {
  Simulation s;
  for (int i = 0; i < 500; ++i) s.step({});
  double sway = 0;
  for (int i = 0; i < 1500; ++i) {
    s.step(i < 100 ? Vec3{100, 0, 0} : Vec3{});
    sway = std::max(sway, (s.X[0] * Vec3{0, 0, 0.4}).x);
  }
  EXPECT_FALSE(s.last.released);
  EXPECT_GT(sway, 0.005);
  EXPECT_LT(std::fabs(s.state.q[0]), 0.02);
  const double at_end = (s.X[0] * Vec3{0, 0, 0.4}).x;
  EXPECT_LT(std::fabs(at_end), 0.3 * sway) << "most of the sway should be recovered";
  for (const double v : s.state.v) EXPECT_LT(std::fabs(v), 0.02) << "the character should be at rest";
}

TEST(MotionControl, IsTheSameAtAnotherPlaceAndHeading) {
  ControlOptions options;
  options.assist_limit = 0.05;  // the friction pyramids have an effect if the assist is small
  const Placement place{50, -20, 0, 0.65};
  Simulation here(options), there(options, place);
  std::vector<double> error(here.state.v.size());
  for (int i = 0; i < 800; ++i) {
    const Vec3 push = i > 100 && i < 200 ? Vec3{200, 150, 0} : Vec3{};
    here.step(push);
    there.step(rotation_about({0, 0, 1}, place.heading) * push);
    std::vector<double> moved = here.state.q;
    displace_root(*here.m, place, moved);
    difference(*here.m, moved, there.state.q, error);
    for (const double e : error) ASSERT_NEAR(e, 0, 1e-6) << "tick " << i;
    ASSERT_NEAR(here.last.size_bw, there.last.size_bw, 1e-6) << "tick " << i;
  }
}

TEST(MotionControl, ReleasesControlAfterAFallWithoutHiddenAssist) {
  ControlOptions options;
  options.assist_limit = 0.2;
  Simulation s(options);
  for (int i = 0; i < 500; ++i) s.step({});
  for (int i = 0; i < 1500; ++i) {
    s.step(i < 100 ? Vec3{1500, 0, 0} : Vec3{});
    EXPECT_LE(norm(s.last.assist.v), (0.2 + 1e-9) * 9.81 * s.m->mass()) << "the applied assist should stay below the cap";
    if (!s.last.released) continue;
    EXPECT_EQ(norm(s.last.assist.v) + norm(s.last.assist.w), 0);
    for (const double t : s.state.tau) EXPECT_EQ(t, 0);
  }
  EXPECT_TRUE(s.last.released);
  EXPECT_LT(s.state.q[2], 0.4);  // m: the character has fallen to the ground
  // The character is put back on its feet at rest, but remains a ragdoll.
  s.state.q = s.m->neutral();
  s.state.q[2] = 0.91;
  s.state.v.assign(s.state.v.size(), 0.0);
  s.memory.departure = 0;
  for (double& shift : s.memory.shift) shift = 0;
  for (int i = 0; i < 1000; ++i) s.step(i < 10 ? Vec3{50, 20, 0} : Vec3{});
  EXPECT_TRUE(s.last.released);
  EXPECT_LT(s.state.q[2], 0.6);
}

TEST(MotionControl, AssistStaysBelowCapAndCarriesUnsupportedCharacter) {
  ControlOptions options;
  options.assist_limit = 1.2;
  Simulation s(options);
  s.state.q[2] = s.reference[2] = 2.0;  // m: in the air; the assist carries and reports the weight
  for (int i = 0; i < 500; ++i) {
    s.step({});
    EXPECT_LE(s.last.size_bw, 1.2 + 1e-12);
  }
  EXPECT_NEAR(s.last.size_bw, 1.0, 0.01);
  EXPECT_NEAR(s.state.q[2], 2.0, 0.01);
}

TEST(MotionControl, HelpsUpToTheCapWhileTheCharacterFollows) {
  ControlOptions options;
  options.assist_limit = 0.2;
  Simulation s(options);
  for (int i = 0; i < 500; ++i) s.step({});
  int at_cap = 0;
  for (int i = 0; i < 2500; ++i) {
    s.step(i < 50 ? Vec3{600, 0, 0} : Vec3{});
    EXPECT_LE(s.last.size_bw, 0.2 + 1e-12);
    if (s.last.ratio > 1) ++at_cap;
  }
  EXPECT_GT(at_cap, 30) << "the push should need more than the cap for 60 ms";
  EXPECT_FALSE(s.last.released);
  EXPECT_NEAR(s.state.q[2], 0.91, 0.01);
}

TEST(MotionControl, JointsKeepTheirAccelerationsWhereTheAssistIsCapped) {
  // In the air, the forward dynamics of the torques and the capped assist must give the joints the accelerations of the reference, although
  // the root would need far more assist.
  Simulation s;
  s.state.q[2] = s.reference[2] = 3;
  std::vector<double> a(s.rest.size());
  for (std::size_t i = 0; i < a.size(); ++i) a[i] = i < 6 ? 40.0 - 13.0 * static_cast<double>(i) : 3.0 * static_cast<double>(i % 4) - 4;
  s.last = s.control.step({s.state.q, s.state.v, s.reference, s.rest, a, {}, 0, 0.002}, s.memory, s.state.tau, s.gain, s.target);
  ASSERT_GT(s.last.ratio, 2);
  dynamics::Workspace ws(*s.m);
  std::vector<double> vdot(a.size());
  s.state.external[0] = MotionControl::about_world_origin(s.last.assist, {0, 0, 3});
  ASSERT_TRUE(dynamics::calc_forward_dynamics(*s.m, ws, s.state.q, s.state.v, s.state.tau, {0, 0, -9.81}, s.state.external, vdot));
  for (std::size_t i = 6; i < a.size(); ++i) EXPECT_NEAR(vdot[i], a[i], 1e-8) << i;
}

TEST(MotionControl, FeetThatSlideWhileTheyLandBearLoad) {
  // The character and its reference glide along the floor. Without load the character is in free fall, and its joints need no torques. In
  // both cases the ground can push the feet: the joints above them resist it, because a foot alone has too little inertia to keep its
  // place.
  for (const double speed : {0.5, 2.0, 4.0}) {
    Simulation s;
    std::vector<double> v = s.rest;
    v[3] = s.state.v[3] = speed;
    s.reference[2] += 0.005;
    calc_poses(*s.m, s.state.q, s.X);
    const std::span<const Pose> poses(s.X);
    collision::find_contacts(s.scene, std::span(&poses, 1), 0.02, s.workspace, s.contacts);
    s.last = s.control.step({s.state.q, s.state.v, s.reference, v, s.rest, s.contacts, 0, 0.002}, s.memory, s.state.tau, s.gain, s.target);
    if (speed < 3)
      EXPECT_GT(s.memory.shift[2], -0.001) << speed;
    else
      EXPECT_LT(s.memory.shift[2], -0.004) << speed;
    EXPECT_GT(s.gain[6], 0) << speed;
  }
}

TEST(MotionControl, AFootThatTouchesTheGroundUnplannedResistsIt) {
  // The reference is 42.5 mm above the floor, so that no foot is planted in it. The servo of a foot on the floor resists the ground, which
  // would turn the foot under the body; that of a foot in the air is off.
  for (const double height : {0.0, 0.1}) {
    Simulation s;
    s.reference[2] += 0.0425;
    s.state.q[2] += height;
    calc_poses(*s.m, s.state.q, s.X);
    const std::span<const Pose> poses(s.X);
    collision::find_contacts(s.scene, std::span(&poses, 1), 0.02, s.workspace, s.contacts);
    s.last =
        s.control.step({s.state.q, s.state.v, s.reference, s.rest, s.rest, s.contacts, 0, 0.002}, s.memory, s.state.tau, s.gain, s.target);
    for (std::size_t i = 6; i < s.gain.size(); ++i) EXPECT_EQ(s.gain[i] > 0, height == 0) << i;
  }
}

TEST(MotionControl, FallsFreelyWithoutSupportAndStandsAgain) {
  Simulation s;
  s.state.q[2] = 1.11;  // m: 0.2 m too high, like the reference
  s.reference[2] = 1.11;
  for (int i = 0; i < 50; ++i) {
    s.step({});
    if (i < 25) EXPECT_LT(s.last.size_bw, 0.01) << i;  // later the assist slows the fall slightly
  }
  EXPECT_NEAR(s.state.q[2], 1.11 - 0.5 * 9.81 * 0.1 * 0.1, 0.002);
  for (int i = 0; i < 1500; ++i) s.step({});
  EXPECT_FALSE(s.last.released);
  EXPECT_NEAR(s.state.q[2], 0.91, 0.01);
  EXPECT_LT(s.last.size_bw, 0.01);
  EXPECT_NEAR(s.memory.shift[2], -0.2, 0.01);  // m: the root trajectory has shifted down with the fall
}

TEST(MotionControl, ReleasesControlAfterFallingTooDeep) {
  Simulation s;
  s.state.q[2] = s.reference[2] = 2.5;
  int steps = 0;
  while (!s.last.released && steps < 1000) {
    s.step({});
    ++steps;
  }
  EXPECT_TRUE(s.last.released);
  EXPECT_LT(s.state.q[2], 2.5 - 0.5 * 0.5 * s.control.lever());
  EXPECT_GT(s.state.q[2], 0.91);
}

TEST(MotionControl, FliesFreelyDuringAJump) {
  // The reference jumps: up at 2 m/s, free flight, landing. The character starts with the same state.
  Simulation s;
  const double g = 9.81, up = 2;
  s.state.v[5] = up;
  std::vector<double> v(s.rest.size()), a(s.rest.size());
  for (int i = 0; i < 180; ++i) {
    const double t = 0.002 * i;
    calc_poses(*s.m, s.state.q, s.X);
    const std::span<const Pose> poses(s.X);
    collision::find_contacts(s.scene, std::span(&poses, 1), 0.02, s.workspace, s.contacts);
    s.reference[2] = 0.91 + up * t - 0.5 * g * t * t;
    v[5] = up - g * t;
    a[5] = -g;
    s.last = s.control.step({s.state.q, s.state.v, s.reference, v, a, s.contacts, 0, 0.002}, s.memory, s.state.tau, s.gain, s.target);
    contact::StepSystem system{s.state.q, s.state.v, s.state.tau, s.state.external, s.gain, s.target};
    ASSERT_EQ(s.stepper.step(std::span(&system, 1), s.contacts, 0.002).status, contact::StepStatus::ok);
    if (i > 10) EXPECT_LT(s.last.size_bw, 0.02) << t;
  }
  EXPECT_NEAR(s.state.q[2], s.reference[2], 0.01);
}

TEST(MotionControl, DoesNotDriveJointsWithoutEffort) {
  // A trunk with an arm that has a drive and a tail of two links that has none, in the air with unlimited assist.
  MechanismSpec spec;
  spec.name = "tailed";
  for (const char* name : {"trunk", "arm", "tail", "tip"}) {
    LinkSpec l;
    l.name = name;
    if (l.name != "trunk") l.parent = l.name == "tip" ? "tail" : "trunk";
    l.joint.type = l.name == "trunk" ? JointType::floating : JointType::revolute;
    l.joint.axis = l.name == "tip" ? Vec3{0, 0, 1} : Vec3{0, 1, 0};
    l.joint.X_PJ.p = l.name == "tip" ? Vec3{-0.3, 0, 0} : l.name == "arm" ? Vec3{0.2, 0, 0} : l.name == "tail" ? Vec3{-0.2, 0, 0} : Vec3{};
    if (l.name == "tail" || l.name == "tip") {
      l.joint.dofs[0].effort = 0;
      l.joint.dofs[0].stiffness = 3;
      l.joint.dofs[0].damping = 0.2;
    }
    const Shape shape = Shape::capsule(0.05, {0, 0, 0}, {l.name == "arm" ? 0.3 : -0.3, 0, 0});
    l.inertia = solid_inertia(shape, 1000);
    l.shapes.push_back(shape);
    spec.links.push_back(l);
  }
  const MechanismPtr m = Mechanism::make(std::move(spec)).value();
  ControlOptions options;
  options.assist_limit = 100;
  MotionControl control(m, options);
  ControlState memory;
  State s(*m);
  s.q[2] = 1;
  const std::vector<double> reference = s.q, rest(static_cast<std::size_t>(m->nv()), 0.0);
  s.q[7] = 0.2;   // arm
  s.q[8] = 0.5;   // tail
  s.q[9] = -0.4;  // tip
  s.v[6] = 1;
  s.v[7] = -3;
  s.v[8] = 2;
  std::vector<double> tau(rest.size()), gain(rest.size()), target(rest.size());
  constexpr double dt = 1e-6;  // s: short, so that explicit and implicit forces are equal
  const ControlOutput out = control.step({s.q, s.v, reference, rest, rest, {}, 0, dt}, memory, tau, gain, target);
  EXPECT_EQ(tau[7], 0);
  EXPECT_EQ(tau[8], 0);
  EXPECT_EQ(gain[7], 0);
  // Forward dynamics with the torques, the assist and the springs: root and arm have the accelerations that the controller wants.
  std::vector<double> total = tau, a(rest.size());
  for (const std::size_t i : {7u, 8u}) total[i] -= 3 * s.q[i + 1] + 0.2 * s.v[i];
  std::vector<Vec6> wrenches(4);
  wrenches[0] = MotionControl::about_world_origin(out.assist, {s.q[0], s.q[1], s.q[2]});
  dynamics::Workspace ws(*m);
  ASSERT_TRUE(dynamics::calc_forward_dynamics(*m, ws, s.q, s.v, total, {0, 0, -9.81}, wrenches, a));
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(a[i], 0, 0.01) << i;
  const double w = control.options().joint_frequency;
  EXPECT_NEAR(a[6], -w * w * 0.2 - 2 * w * 1.0, 0.05);
}

/// The biped with all lengths multiplied by `scale`; equal density.
MechanismPtr biped_of_size(double scale) {
  MechanismSpec spec = biped()->spec();
  for (LinkSpec& l : spec.links) {
    l.joint.X_PJ.p = l.joint.X_PJ.p * scale;
    const Shape& s = l.shapes[0];
    l.shapes = {s.type == ShapeType::box ? Shape::box(s.half_extents * scale, {s.X_BS.R, s.X_BS.p * scale})
                                         : Shape::capsule(s.radius * scale, {0, 0, -0.1 * scale}, {0, 0, -0.75 * scale})};
    l.inertia = solid_inertia(l.shapes[0], 1000);
  }
  return Mechanism::make(std::move(spec)).value();
}

// Dynamic similarity: of two characters whose sizes differ by a factor, in the same pose and with speeds in the ratio of the square root,
// the torques have the ratio of the weights times the lengths.
TEST(MotionControl, SmallCharactersMoveLikeLargeOnes) {
  constexpr double scale = 0.25, time = 0.5;
  const MechanismPtr large = biped_of_size(0.8 / MotionControl(biped(), {}).lever()),
                     small = [&] { return biped_of_size(0.8 / MotionControl(biped(), {}).lever() * scale); }();
  std::vector<double> torque[2];
  ControlOutput out[2];
  for (const bool is_small : {false, true}) {
    const MechanismPtr& m = is_small ? small : large;
    MotionControl control(m, {});
    EXPECT_NEAR(control.lever(), is_small ? 0.2 : 0.8, 1e-9);
    State s(*m);
    const double length = is_small ? scale : 1, speed = is_small ? time : 1;
    s.q[0] = 0.03 * length;
    s.q[2] = 0.9 * length;
    const std::vector<double> reference = m->neutral(), rest(static_cast<std::size_t>(m->nv()), 0.0);
    std::vector<double> goal = reference;
    goal[2] = 0.88 * length;
    for (std::size_t k = 0; k < 3; ++k) {
      s.v[k] = 0.2 * (static_cast<double>(k) + 1) / (is_small ? time : 1);  // rad/s
      s.v[3 + k] = 0.3 * (2 - static_cast<double>(k)) * speed;              // m/s
    }
    const std::vector<double> turn = {0.1, -0.2, 0.05, 0.15, 0.1, -0.1, -0.2, 0.05, 0.1, 0.02, -0.1, 0.1};
    std::vector<double> step(rest.size(), 0.0);
    std::ranges::copy(turn, step.begin() + 6);
    const std::vector<double> start = s.q;
    integrate(*m, start, step, 1.0, s.q);
    ControlState memory;
    std::vector<double> gain(rest.size()), target(rest.size());
    torque[is_small ? 1 : 0].resize(rest.size());
    out[is_small ? 1 : 0] =
        control.step({s.q, s.v, goal, rest, rest, {}, 0, 0.002 * (is_small ? time : 1)}, memory, torque[is_small ? 1 : 0], gain, target);
  }
  const double force = std::pow(scale, 3), moment = force * scale;
  for (std::size_t i = 6; i < torque[0].size(); ++i)
    EXPECT_NEAR(torque[1][i] / moment, torque[0][i], 1e-6 * (1 + std::fabs(torque[0][i]))) << i;
  EXPECT_GT(std::fabs(torque[0][7]), 1);
  EXPECT_NEAR(out[0].size_bw, out[1].size_bw, 1e-9);
  EXPECT_NEAR(norm(out[0].assist.v), norm(out[1].assist.v) / force, 1e-6);
}

}  // namespace
}  // namespace ugoki::control
