#include "ugoki/control/fall_control.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "ugoki/contact/guarded_step.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/samples/samples.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::control {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// A person who topples over from a lean, without balance control.
struct Topple {
  static constexpr double dt = 0.002;
  MechanismPtr m;
  collision::Scene scene;
  collision::Workspace workspace{scene};
  contact::Stepper stepper;
  contact::GuardedStep guard{scene, stepper};
  FallControl control;
  FallState memory;
  dynamics::Workspace ws{*m};
  int head = 0;
  State state{*m};
  std::vector<double> upright, gain, velocity;
  std::vector<Pose> X;
  std::vector<collision::ContactPoint> contacts;
  bool ragdoll = false;      // no drives
  std::vector<Vec3> speeds;  // m/s: velocity of the head after each step
  std::string first;         // label of the first link, except legs and feet, that touches the ground

  Topple(double height, double direction)
      : m(samples::make_person(height).value()), scene({m}), stepper({m}, {}), control(m, {.get_up = false}), upright(m->neutral()) {
    gain.resize(state.v.size());
    velocity.resize(state.v.size());
    X.resize(at(m->link_count()));
    for (int i = 0; i < m->link_count(); ++i)
      if (m->link(i).label == "head") head = i;
    calc_poses(*m, upright, X);
    double low = 1;
    for (int i = 0; i < m->link_count(); ++i)
      for (const Shape& s : m->link(i).shapes) {
        const Pose P = X[at(i)] * s.X_BS;
        low = std::min(low, P.p.z - reach(s, transpose_times(P.R, Vec3{0, 0, -1})));
      }
    upright[2] -= low;
    state.q = upright;
    // Rotate by 0.35 rad about a point of the ground, and start with the speed of the fall.
    const Vec3 d{ugoki::cos(direction), ugoki::sin(direction), 0}, axis = cross(Vec3{0, 0, 1}, d);
    const Mat3 R = rotation_about(axis, 0.35);
    const Quat r = to_quat(R * X[0].R);
    const Vec3 p = R * Vec3{0, 0, upright[2]} + Vec3{0, 0, 0.03}, w = axis * 1.2, v = cross(w, p);
    for (int k = 0; k < 3; ++k) state.q[at(k)] = p[k];
    state.q[3] = r.w, state.q[4] = r.x, state.q[5] = r.y, state.q[6] = r.z;
    const Vec3 local = transpose_times(R * X[0].R, w);
    for (int k = 0; k < 3; ++k) state.v[at(k)] = local[k], state.v[at(3 + k)] = v[k];
  }
  void step() {
    calc_poses(*m, state.q, X);
    const std::span<const Pose> poses(X);
    workspace.forget();
    collision::find_contacts(scene, std::span(&poses, 1), 0.02, workspace, contacts);
    for (const collision::ContactPoint& c : contacts) {
      const std::string& label = m->link(c.link_a).label;
      const bool leg = label.starts_with("foot") || label.starts_with("toes") || label.starts_with("shank") || label.starts_with("thigh");
      if (first.empty() && c.distance < 1e-3 && !leg) first = label;
    }
    std::ranges::fill(state.tau, 0.0);
    std::ranges::fill(gain, 0.0);
    std::ranges::fill(velocity, 0.0);
    control.check(state.q, state.v, upright, {}, dt, memory);
    control.brace(state.q, state.v, dt, memory, state.tau, gain, velocity);
    if (ragdoll) {
      std::ranges::fill(state.tau, 0.0);
      std::ranges::fill(gain, 0.0);
    }
    if (!ragdoll && memory.mode >= static_cast<std::uint64_t>(FallMode::fall))
      control.step(state.q, state.v, contacts, 0, dt, memory, state.tau, gain, velocity);
    contact::StepSystem system{state.q, state.v, state.tau, state.external, gain, velocity};
    guard.forget();
    ASSERT_EQ(guard.step(std::span(&system, 1), contacts, dt).status, contact::StepStatus::ok);
    dynamics::update_kinematics(*m, state.q, state.v, ws);
    speeds.push_back(dynamics::point_velocity(ws, head, ws.X_WB[at(head)] * m->link(head).inertia.centre()));
  }
};

/// Maximum mean acceleration [m/s^2] of the head within 15 ms, the time window of the head injury criterion HIC15.
double head_peak(const Topple& t) {
  constexpr std::size_t window = 8;
  double peak = 0;
  for (std::size_t i = window; i < t.speeds.size(); ++i)
    peak = std::max(peak, norm(t.speeds[i] - t.speeds[i - window]) / (window * Topple::dt));
  return peak;
}

TEST(FallControl, ProtectsTheHead) {
  double protect = 0, limp = 0;
  for (const double direction : {0.3, 1.9, 3.5}) {
    Topple t(1.7, direction), r(1.7, direction);
    r.ragdoll = true;
    for (int i = 0; i < 750; ++i) {
      t.step();
      r.step();
      if (HasFatalFailure()) return;
    }
    protect += head_peak(t) / 3;
    limp += head_peak(r) / 3;
  }
  EXPECT_LT(protect, 0.75 * limp);
}

TEST(FallControl, FallsOnTheHandsAndComesToRest) {
  for (const double direction : {0.0, 2.0}) {
    Topple t(1.7, direction);
    for (int i = 0; i < 1500; ++i) {
      t.step();
      if (HasFatalFailure()) return;
    }
    EXPECT_TRUE(t.first.starts_with("hand") || t.first.starts_with("fingers")) << t.first << ", direction " << direction;
    EXPECT_EQ(t.memory.mode, static_cast<std::uint64_t>(FallMode::lie));
  }
}

TEST(FallControl, RulesHoldForAChild) {
  for (const double direction : {0.0, 2.0}) {
    Topple t(1.1, direction);
    for (int i = 0; i < 1200; ++i) {
      t.step();
      if (HasFatalFailure()) return;
    }
    EXPECT_TRUE(t.first.starts_with("hand") || t.first.starts_with("fingers")) << t.first << ", direction " << direction;
    EXPECT_EQ(t.memory.mode, static_cast<std::uint64_t>(FallMode::lie));
  }
}

TEST(FallControl, BracesBeforeItFallsAndRelaxes) {
  const MechanismPtr m = samples::make_person(1.7).value();
  FallControl control(m, {});
  FallState state;
  std::vector<double> q = m->neutral(), v(at(m->nv()));
  q[2] = 1;
  const auto wait = [&](const Vec3& dcm_error, double seconds) {
    for (int i = 0; i < static_cast<int>(seconds / 0.002 + 0.5); ++i) control.check(q, v, q, dcm_error, 0.002, state);
    return static_cast<FallMode>(state.mode);
  };
  EXPECT_DOUBLE_EQ(control.check(q, v, q, {}, 0.002, state), 1);
  EXPECT_EQ(wait({2, 0, 0}, 0.02), FallMode::track);  // shorter than the delay
  EXPECT_EQ(wait({}, 0.1), FallMode::track);
  EXPECT_EQ(wait({0.9, 0, 0}, 0.1), FallMode::brace);
  EXPECT_EQ(wait({}, 0.2), FallMode::brace);
  EXPECT_EQ(wait({}, 0.2), FallMode::track);
  EXPECT_EQ(wait({3, 0, 0}, 0.2), FallMode::fall);
  EXPECT_EQ(wait({}, 1), FallMode::fall);  // a fall does not end by itself
}

/// On a platform of 1 m, half of the body's height is a fall; above the floor of the world it would be three quarters of its height.
TEST(FallControl, MeasuresHeightsFromTheGroundUnderTheBody) {
  const MechanismPtr m = samples::make_person(1.7).value();
  LinkSpec box;
  box.name = "platform";
  box.joint.type = JointType::fixed;
  box.shapes.push_back(Shape::box({2, 2, 0.5}, {Mat3::identity(), {0, 0, 0.5}}));
  MechanismSpec spec;
  spec.name = "platform";
  spec.links.push_back(std::move(box));
  const std::vector<MechanismPtr> systems{m, Mechanism::make(std::move(spec)).value()};
  std::vector<double> upright = m->neutral(), v(at(m->nv()));
  std::vector<Pose> X(at(m->link_count()));
  calc_poses(*m, upright, X);
  upright[2] += 1 + 0.95 - centre_of_mass(*m, X).z;
  for (const double x : {0.0, 5.0}) {  // on the platform, beside it
    std::vector<double> low = upright;
    upright[0] = low[0] = x;
    low[2] -= 0.475;
    FallControl control(m, {}, GroundMap(systems, 0, 0));
    FallState state;
    for (int i = 0; i < 100; ++i) control.check(low, v, upright, {}, 0.002, state);
    EXPECT_EQ(static_cast<FallMode>(state.mode), x == 0 ? FallMode::fall : FallMode::brace);
  }
}

TEST(FallControl, SameBitsAfterRestore) {
  Topple a(1.7, 0.4), b(1.7, 0.4);
  for (int i = 0; i < 200; ++i) a.step();
  b.state.q = a.state.q;
  b.state.v = a.state.v;
  b.memory = a.memory;
  b.stepper.set_warm(a.stepper.warm());
  for (int i = 0; i < 300; ++i) {
    a.step();
    b.step();
  }
  EXPECT_EQ(a.state.q, b.state.q);
  EXPECT_EQ(a.state.v, b.state.v);
}

TEST(PoseFinder, ReachesAPointWithinTheLimits) {
  const MechanismPtr m = samples::make_person(1.7).value();
  const std::optional<BodyPlan> plan = body_plan_of(*m);
  ASSERT_TRUE(plan);
  PoseFinder finder(m);
  std::vector<double> q = m->neutral();
  std::vector<Pose> X(at(m->link_count()));
  calc_poses(*m, q, X);
  const Effector& hand = plan->place(0, Place::hand);
  const Pose root = X[0];
  const Vec3 target = X[at(plan->upper_arm[0])].p + Vec3{0.7, 0.2, -0.3} * plan->arm_length;
  for (int i = 0; i < 60; ++i) {
    finder.begin(q);
    finder.add_point(0, {}, root.p, {1e3, 1e3, 1e3});
    finder.add_turn(0, root.R, 1e3);
    finder.add_point(hand.link, hand.point, target, {1, 1, 1});
    finder.step(q, 1e-4, 0.3, q);
  }
  calc_poses(*m, q, X);
  EXPECT_LT(norm(X[at(hand.link)] * hand.point - target), 1e-3);
  for (const Link& link : m->links()) {
    if (link.joint.type == JointType::floating) continue;
    double x[6];
    joint_displacement(link.joint, q.data() + link.q_index, x);
    for (int k = 0; k < link.joint.nv(); ++k) {
      EXPECT_LE(x[k], link.joint.dofs[at(k)].upper + 1e-9) << link.name;
      EXPECT_GE(x[k], link.joint.dofs[at(k)].lower - 1e-9) << link.name;
    }
  }
}

TEST(PostureServo, KeepsTorqueLimits) {
  const MechanismPtr m = samples::make_person(1.7).value();
  dynamics::Workspace ws(*m);
  const std::vector<double> q = m->neutral();
  const std::size_t n = at(m->nv());
  std::vector<double> v(n, 0.5), error(n, 3.0), gradient(n, 1e4), tau(n), gain(n), velocity(n);
  dynamics::update_kinematics(*m, q, v, ws);
  dynamics::calc_inertia_rows(*m, ws);
  set_posture_servo(ws, {40, 1, 1, 0.5}, 0.002, v, error, gradient, tau, gain, velocity);
  for (std::size_t i = 0; i < n; ++i) {
    if (i < 6)
      EXPECT_EQ(gain[i], 0);
    else
      EXPECT_LE(std::fabs(tau[i] + gain[i] * (velocity[i] - v[i])), 0.5 * ws.dofs[i].effort * (1 + 1e-12));
  }
}

}  // namespace
}  // namespace ugoki::control
