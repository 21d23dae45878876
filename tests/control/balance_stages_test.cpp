// Stages of balance control: schedule of the feet, support, anchor, limits, flights, ground that the reference does not contain.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "balance_scene.h"
#include "ugoki/control/ground_plan.h"
#include "ugoki/control/leg_posture.h"
#include "ugoki/control/reference_anchor.h"
#include "ugoki/control/swing_path.h"
#include "ugoki/motion/clip.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::control {
namespace {

/// The standing sample human, changed by a function of time. Velocities and accelerations are central differences.
class ChangedStand final : public ReferenceMotion {
 public:
  using Change = std::function<void(double t, std::span<double> q)>;
  ChangedStand(const Walker& w, double length, Change change)
      : m_(w.body.mechanism), stand_(m_, motion_of(w.body, samples::make_human_stand()), length), change_(std::move(change)) {}
  void sample(double t, std::span<double> q, std::span<double> v, std::span<double> a) const override {
    constexpr double h = 1e-4;  // s
    std::vector<double> before(q.size()), after(q.size()), v_after(v.size());
    position(t, q);
    position(t - h, before);
    position(t + h, after);
    difference(*m_, before, q, v);
    difference(*m_, q, after, v_after);
    for (std::size_t i = 0; i < v.size(); ++i) {
      a[i] = (v_after[i] - v[i]) / (h * h);
      v[i] = 0.5 * (v[i] + v_after[i]) / h;
    }
  }
  [[nodiscard]] double end() const override { return stand_.end(); }

 private:
  void position(double t, std::span<double> q) const {
    std::vector<double> v(static_cast<std::size_t>(m_->nv())), a(v.size());
    stand_.sample(0, q, v, a);
    change_(t, q);
  }
  MechanismPtr m_;
  Looped stand_;
  Change change_;
};

/// A height that follows a parabola of free fall from 0.5 s to 0.5 s + 2 v / g, and is 0 otherwise.
double jump_height(double t, double v) { return std::max(0.0, v * (t - 0.5) - 0.5 * 9.81 * (t - 0.5) * (t - 0.5)); }

TEST(FootSchedule, FindsTurnsOnTheGround) {
  const Walker w;
  // The character turns by 1 rad from 1 s to 2 s.
  const ChangedStand turn(
      w, 3, [&](double t, std::span<double> q) { displace_root(*w.body.mechanism, {0, 0, 0, std::clamp(t - 1, 0.0, 1.0)}, q); });
  const std::vector<Foot> feet = feet_of(*w.body.mechanism);
  const FootSchedule schedule(*w.body.mechanism, feet, turn, 0);
  for (std::size_t f = 0; f < 2; ++f) {
    ASSERT_EQ(schedule.turns(f).size(), 1u);
    EXPECT_NEAR(schedule.turns(f)[0].begin, 1, 0.02);
    EXPECT_NEAR(schedule.turns(f)[0].end, 2, 0.02);
    EXPECT_TRUE(schedule.turns(f, 1.5));
    EXPECT_FALSE(schedule.turns(f, 0.5));
    EXPECT_FALSE(schedule.turns(f, 2.5));
  }
  const Looped walk(w.body.mechanism, motion_of(w.body, w.walk), 10);
  const FootSchedule walking(*w.body.mechanism, feet, walk, 0);
  EXPECT_TRUE(walking.turns(0).empty() && walking.turns(1).empty()) << "the feet of a walk roll, but do not turn";
}

TEST(FootSchedule, FindsFlights) {
  const Walker w;
  const ChangedStand jump(w, 3, [&](double t, std::span<double> q) { displace_root(*w.body.mechanism, {0, 0, jump_height(t, 2), 0}, q); });
  const FootSchedule schedule(*w.body.mechanism, feet_of(*w.body.mechanism), jump, 0);
  ASSERT_EQ(schedule.flights().size(), 1u);
  const Flight flight = schedule.flights()[0];
  EXPECT_NEAR(flight.begin, 0.5, 0.03);
  EXPECT_NEAR(flight.end, 0.5 + 4 / 9.81, 0.03);
  std::vector<double> q(static_cast<std::size_t>(w.body.mechanism->nq())), v(static_cast<std::size_t>(w.body.mechanism->nv())), a(v.size());
  jump.sample(flight.end, q, v, a);
  std::vector<Pose> X(static_cast<std::size_t>(w.body.mechanism->link_count()));
  calc_poses(*w.body.mechanism, q, X);
  EXPECT_NEAR(flight.landing, centre_of_mass(*w.body.mechanism, X).z, 0.02);
  EXPECT_EQ(schedule.flight(0.2), nullptr);
  EXPECT_NE(schedule.flight(0.7), nullptr);
}

TEST(GroundSupport, PointsOfATurningFootSlideAboutOnePoint) {
  const Walker w;
  const auto turn = std::make_shared<const ChangedStand>(
      w, 3, [&](double t, std::span<double> q) { displace_root(*w.body.mechanism, {0, 0, 0, std::clamp(t - 1, 0.0, 1.0)}, q); });
  Simulation s(w.body.mechanism, turn);
  s.step();
  BalanceModel model(s.m, turn, {}, 0);
  GroundSupport support(model);
  BalanceState state;
  state.feet[0].stands = state.feet[1].stands = 1;
  const auto points = [&](double time) {
    state.time = time;
    turn->sample(time, s.state.q, s.state.v, model.a_ref);
    dynamics::update_kinematics(*s.m, s.state.q, s.state.v, model.now);
    model.sample_reference(state);
    support.collect(model, {s.state.q, s.state.v, s.contacts, 0, 0.002});
    support.find_bearing(model, state, {});
    return support.bearing();
  };
  for (const BearingPoint& b : points(0.5)) EXPECT_EQ(norm(b.slide), 0);
  const std::vector<BearingPoint> turning = points(1.5);
  ASSERT_GE(turning.size(), 4u);
  for (const BearingPoint& a : turning)
    for (const BearingPoint& b : turning)
      if (a.foot == b.foot) {  // rigid rotation about z at 1 rad/s
        const Vec3 relative = a.slide - b.slide - cross(Vec3{0, 0, 1}, a.p - b.p);
        EXPECT_LT(norm(relative), 0.02);
      }
}

TEST(ReferenceAnchor, FollowsTheFootThatStaysAndNotTheFootThatLanded) {
  // The left foot touches the ground between 1 s and 1.6 s. The right foot stands all the time and carries the character afterwards.
  const Walker w;
  const std::vector<Foot> feet = feet_of(*w.body.mechanism);
  const bool first_is_left = w.body.mechanism->link(feet[0].link).label.ends_with("left");
  const std::size_t left = first_is_left ? 0 : 1;
  const auto raised = std::make_shared<const ChangedStand>(w, 3, [&](double t, std::span<double> q) {
    std::vector<double> v(static_cast<std::size_t>(w.body.mechanism->nv()));
    const double up = std::max(std::clamp((1 - t) / 0.1, 0.0, 1.0), std::clamp((t - 1.6) / 0.1, 0.0, 1.0));
    for (const int dof : feet[left].dofs) v[static_cast<std::size_t>(dof)] = 0.5 * up;  // rad: bends the leg
    std::vector<double> bent(q.size());
    integrate(*w.body.mechanism, q, v, 1, bent);
    std::ranges::copy(bent, q.begin());
  });
  BalanceModel model(w.body.mechanism, raised, {}, 0);
  ASSERT_FALSE(model.schedule.at(left, 0.5).stands);
  ASSERT_TRUE(model.schedule.at(left, 1.3).stands);
  ASSERT_FALSE(model.schedule.at(left, 2.5).stands);
  ASSERT_TRUE(model.schedule.at(1 - left, 1.3).stands);
  ReferenceAnchor anchor;
  BalanceState state;
  state.feet[0].stands = state.feet[1].stands = 1;
  state.time = model.schedule.at(left, 1.3).end - 0.01;  // s: the left foot lifts soon
  model.sample_reference(state);
  std::vector<double> q = model.q_ref, v(model.v_ref.size());
  const double bend = 0.3;  // rad: displaces the left foot of the character
  for (const int dof : feet[left].dofs) v[static_cast<std::size_t>(dof)] = bend;
  integrate(*model.mechanism, model.q_ref, v, 1, q);
  dynamics::update_kinematics(*model.mechanism, q, v, model.now);
  model.centroid = dynamics::calc_centroidal(*model.mechanism, model.now);
  const Vec3 offset = horizontal(model.sole(left) - model.reference_sole(left));
  ASSERT_GT(norm(offset), 0.05);
  anchor.update(model, model.options.anchor_time, state);
  EXPECT_LT(std::hypot(state.x, state.y), 0.15 * norm(offset));
}

TEST(ReferenceAnchor, TurnsBackToItsHeadingOnASlopeToo) {
  const Walker w;
  const auto stand = std::make_shared<const ChangedStand>(w, 3, [](double, std::span<double>) {});
  BalanceModel model(w.body.mechanism, stand, {}, 0);
  BalanceState state;
  state.feet[0].stands = state.feet[1].stands = 1;
  state.time = 1;
  state.heading = 0.2;  // rad: the character has turned as far as its reference
  state.tilt[0] = 0.18;
  model.sample_reference(state);
  dynamics::update_kinematics(*model.mechanism, model.q_ref, model.v_ref, model.now);
  model.centroid = dynamics::calc_centroidal(*model.mechanism, model.now);
  ReferenceAnchor anchor;
  anchor.update(model, model.options.heading_time, state);
  EXPECT_NEAR(state.heading, 0.2 * (1 - model.options.turn_homing), 1e-6);
}

// The distance to the reference's own place was limited by the height above the floor of the scene instead of that above the ground: below
// the floor of the scene, the character walked away from its place.
TEST(ReferenceAnchor, ReturnsToItsPlaceOnHighAndLowGround) {
  const Walker w;
  const auto stand = std::make_shared<const ChangedStand>(w, 3, [](double, std::span<double>) {});
  for (const double height : {0.0, 20.0, -9.0}) {
    BalanceModel model(w.body.mechanism, stand, {}, 0);
    BalanceState state;
    state.feet[0].stands = state.feet[1].stands = 1;
    state.time = 1;
    state.y = 3;  // m
    state.z = height;
    model.sample_reference(state);
    dynamics::update_kinematics(*model.mechanism, model.q_ref, model.v_ref, model.now);
    model.centroid = dynamics::calc_centroidal(*model.mechanism, model.now);
    ReferenceAnchor anchor;
    anchor.update(model, model.options.anchor_time, state);
    EXPECT_NEAR(3 - state.y, model.options.max_homing * (model.want.centre.z - height), 0.002) << height;
  }
}

TEST(BalanceControl, PlanKeepsJointLimits) {
  // One knee has a limit that the reference exceeds by 0.3 rad. The program plans accelerations that keep this limit, so that the step
  // meets the planned accelerations of the knee.
  Walker w;
  MechanismSpec spec = w.body.mechanism->spec();
  int knee = -1;
  for (int i = 0; i < w.body.mechanism->link_count(); ++i)
    if (w.body.mechanism->link(i).label == "shank left") knee = w.body.mechanism->link(i).v_index;
  ASSERT_GE(knee, 0);
  const Looped walk(w.body.mechanism, motion_of(w.body, w.walk), 5);
  std::vector<double> q(static_cast<std::size_t>(w.body.mechanism->nq())), v(static_cast<std::size_t>(w.body.mechanism->nv())), a(v.size());
  double low = 1e9, high = -1e9;
  for (double t = 0; t < 2; t += 0.01) {
    walk.sample(t, q, v, a);
    for (const Link& link : w.body.mechanism->links())
      if (link.v_index == knee) {
        double x[6];
        joint_displacement(link.joint, q.data() + link.q_index, x);
        low = std::min(low, x[0]);
        high = std::max(high, x[0]);
      }
  }
  ASSERT_GT(high - low, 0.6);
  for (LinkSpec& l : spec.links)
    if (l.label == "shank left") {
      Dof& d = l.joint.dofs[0];
      if (std::fabs(high) > std::fabs(low))
        d.upper = high - 0.3;
      else
        d.lower = low + 0.3;
    }
  w.body.mechanism = Mechanism::make(std::move(spec)).value();
  Simulation s(w.body, w.walk, 20);
  std::vector<double> misses;  // rad/s
  for (int i = 0; i < 1000; ++i) {
    const double before = s.state.v[static_cast<std::size_t>(knee)];
    s.step();
    if (HasFatalFailure()) return;
    if (s.last.joint_limits == 0) continue;
    const double got = (s.state.v[static_cast<std::size_t>(knee)] - before) / 0.002;
    misses.push_back(std::fabs(got - s.control.wanted()[static_cast<std::size_t>(knee)]) * 0.002);
  }
  ASSERT_GT(misses.size(), 20u);
  std::ranges::sort(misses);
  EXPECT_LT(misses[misses.size() / 2], 0.02);
}

TEST(BalanceControl, ReferenceLandsWhenTheCharacterLands) {
  const Walker w;
  const auto jump = std::make_shared<const ChangedStand>(
      w, 3, [&](double t, std::span<double> q) { displace_root(*w.body.mechanism, {0, 0, jump_height(t, 2), 0}, q); });
  Simulation s(w.body.mechanism, jump);
  const double start = 0.56;  // s: in the reference, the feet are in the air
  std::vector<double> a(s.state.v.size());
  jump->sample(start, s.state.q, s.state.v, a);
  s.state.v[5] -= 0.5;  // m/s: the character rises more slowly than the reference, so it lands 0.1 s earlier
  s.memory.started = 1;
  s.memory.time = start;
  ASSERT_NE(s.control.schedule().flight(start), nullptr);
  const double end = s.control.schedule().flight(start)->end;
  for (int i = 0; i < 400 && !s.memory.feet[0].stands && !s.memory.feet[1].stands; ++i) {
    s.step();
    if (HasFatalFailure()) return;
  }
  EXPECT_LT(s.memory.clock, end - start - 0.06);
  EXPECT_NEAR(s.memory.time, end, 0.03);
}

TEST(BalanceControl, FeetThatLandTogetherCatchTheDriftOfTheJump) {
  // The character jumps ahead at 0.3 m/s, the reference jumps in place. Both feet land together, so no further step catches this drift.
  const Walker w;
  const auto jump = std::make_shared<const ChangedStand>(
      w, 3, [&](double t, std::span<double> q) { displace_root(*w.body.mechanism, {0, 0, jump_height(t, 2), 0}, q); });
  Simulation s(w.body.mechanism, jump);
  const double start = 0.56, drift = 0.3;  // s: in the reference, the feet are in the air; m/s
  std::vector<double> a(s.state.v.size());
  jump->sample(start, s.state.q, s.state.v, a);
  s.state.v[3] += drift;
  s.memory.started = 1;
  s.memory.time = start;
  for (int i = 0; i < 400 && !s.memory.feet[0].stands && !s.memory.feet[1].stands; ++i) {
    s.step();
    if (HasFatalFailure()) return;
  }
  std::vector<Pose> X(static_cast<std::size_t>(s.m->link_count()));
  calc_poses(*s.m, s.state.q, X);
  const double w0 = std::sqrt(9.81 / centre_of_mass(*s.m, X).z);
  for (std::size_t f = 0; f < 2; ++f) EXPECT_NEAR(s.memory.feet[f].shift[0], 0.8 * drift / w0, 0.015);
  for (int i = 0; i < 500; ++i) {
    s.step();
    if (HasFatalFailure()) return;
    ASSERT_LT(s.below(), 0.1) << "time " << s.memory.clock;
  }
}

/// A fixed plate of 40 m x 40 m, with its top at z = 0 in x = 1 m, and the given slope along x, rad.
MechanismPtr plate(double slope) {
  LinkSpec link;
  link.name = "plate";
  link.joint.type = JointType::fixed;
  const Mat3 R = rotation_about({0, 1, 0}, -slope);
  link.shapes.push_back(Shape::box({20, 20, 0.5}, {R, Vec3{1, 0, 0} + R * Vec3{19, 0, -0.5}}));
  if (slope != 0) link.shapes.push_back(Shape::box({20, 20, 0.5}, {Mat3::identity(), {-19, 0, -0.5}}));
  MechanismSpec spec;
  spec.name = "plate";
  spec.links.push_back(std::move(link));
  return Mechanism::make(std::move(spec)).value();
}

TEST(BalanceControl, WalksOnAFixedMechanism) {
  const Walker w;
  Simulation s(w.body, w.walk, 20, plate(0));
  for (int i = 0; i < 1500; ++i) {
    s.step();
    if (HasFatalFailure()) return;
    ASSERT_LT(s.below(), 0.1) << "time " << 0.002 * i;
  }
}

TEST(BalanceControl, WalksUphill) {
  const Walker w;
  Simulation s(w.body, w.walk, 20, plate(4 * pi / 180));
  for (int i = 0; i < 2500; ++i) {
    s.step();
    if (HasFatalFailure()) return;
    ASSERT_LT(s.below(), 0.2) << "time " << 0.002 * i;
  }
  EXPECT_GT(s.memory.z, 0.1);  // m: the character has climbed
  EXPECT_NEAR(s.memory.tilt[0], std::tan(4 * pi / 180), 0.03);
}

TEST(BalanceControl, ClimbsAStep) {
  // The floor is 8 cm higher from x = 2 m on. Without the map of the ground, the foot hits the step with its tip.
  const Walker w;
  LinkSpec link;
  link.name = "step";
  link.joint.type = JointType::fixed;
  link.shapes.push_back(Shape::box({20, 20, 0.5}, {Mat3::identity(), {22, 0, 0.08 - 0.5}}));
  link.shapes.push_back(Shape::box({20, 20, 0.5}, {Mat3::identity(), {-18, 0, -0.5}}));
  MechanismSpec spec;
  spec.name = "step";
  spec.links.push_back(std::move(link));
  Simulation s(w.body, w.walk, 20, Mechanism::make(std::move(spec)).value());
  for (int i = 0; i < 2000; ++i) {
    s.step();
    if (HasFatalFailure()) return;
    ASSERT_LT(s.below(), 0.2) << "time " << 0.002 * i;
  }
  EXPECT_GT(s.state.q[0], 3);  // m
  EXPECT_NEAR(s.memory.z, 0.08, 1e-3);
}

TEST(LegPosture, ReachesHighAndSlopingGroundAndKeepsTheOtherLeg) {
  const Walker w;
  const auto bent = std::make_shared<const ChangedStand>(w, 3, [&](double, std::span<double> q) {
    // A straight knee would have to bend by a large angle: both legs are bent by the same angles in all joints.
    std::vector<double> v(static_cast<std::size_t>(w.body.mechanism->nv())), moved(q.size());
    for (const Foot& foot : feet_of(*w.body.mechanism))
      for (const int dof : foot.dofs) v[static_cast<std::size_t>(dof)] = 0.3;  // rad
    integrate(*w.body.mechanism, q, v, 1, moved);
    std::ranges::copy(moved, q.begin());
  });
  BalanceModel model(w.body.mechanism, bent, {}, 0);
  BalanceState state;
  state.feet[0].stands = state.feet[1].stands = 1;
  state.feet[0].to[2] = 0.06;    // m: the ground under the first foot is high
  state.feet[0].tilt[0] = 0.15;  // and rises along x
  model.sample_reference(state);
  LegPosture legs(model);
  legs.update(model, state);
  std::vector<Pose> X(static_cast<std::size_t>(model.mechanism->link_count()));
  calc_poses(*model.mechanism, legs.positions(), X);
  const auto at = [&](std::size_t f) { return X[static_cast<std::size_t>(model.feet[f].link)]; };
  const Pose& reference = model.ref.X_WB[static_cast<std::size_t>(model.feet[0].link)];
  const Vec3 moved = at(0) * model.feet[0].sole - model.reference_sole(0);
  EXPECT_NEAR(moved.x, 0, 0.003);
  EXPECT_NEAR(moved.y, 0, 0.003);
  EXPECT_NEAR(moved.z, 0.06, 0.003);
  const Mat3 turned = at(0).R * reference.R.transposed();
  EXPECT_NEAR((turned * Vec3{1, 0, 0}).z, std::sin(std::atan(0.15)), 0.02);  // the sole's x axis rises with the ground
  EXPECT_LT(norm(at(1) * model.feet[1].sole - model.reference_sole(1)), 1e-9);
}

TEST(SwingPath, MeetsBothPlacesAndItsRateIsItsDerivative) {
  BalanceState::FootState foot;
  foot.from[2] = 0.2;
  foot.to[0] = 0.6;
  foot.to[1] = 0.2;
  foot.to[2] = 0.35;
  foot.bump = 0.1;
  foot.sharp[1] = 3.5;
  EXPECT_NEAR(swing_path(foot, {0, 0, 9}, {}, 0.5).height, 0.2, 1e-12);
  EXPECT_NEAR(swing_path(foot, {0.6, 0.2, 9}, {}, 0.5).height, 0.35, 1e-12);
  EXPECT_NEAR(swing_path(foot, {0.3, 0.1, 9}, {}, 0.5).height, 0.275 + 0.1, 1e-12);
  const Vec3 v{0.7, -0.2, 0};  // m/s
  constexpr double h = 1e-6;   // s
  for (const Vec3& p : {Vec3{0.1, 0, 0}, Vec3{0.35, 0.2, 0}, Vec3{0.5, 0.1, 0}}) {
    const double change = swing_path(foot, p + v * h, v, 0).height - swing_path(foot, p - v * h, v, 0).height;
    EXPECT_NEAR(swing_path(foot, p, v, 0).rate, change / (2 * h), 1e-6);
  }
}

TEST(SwingPath, HumpIsOverAllObstaclesAndNotMuchHigher) {
  std::mt19937_64 engine(7);
  std::uniform_real_distribution<double> u(-0.1, 0.2);
  for (int trial = 0; trial < 300; ++trial) {
    std::array<double, Hump::samples> needed{};
    for (double& n : needed) n = u(engine);
    if (trial == 0) needed = {0.1, 0.1, 0, 0, 0, 0, 0};  // a riser just ahead of the foot
    if (trial == 1) needed = {};
    const Hump hump = hump_over(needed);
    BalanceState::FootState foot;  // a way of 1 m on level ground
    foot.to[0] = 1;
    foot.bump = hump.height;
    for (int k = 0; k < 2; ++k) foot.sharp[k] = hump.sharp[k];
    double highest = 0;
    for (std::size_t k = 0; k < Hump::samples; ++k) {
      EXPECT_GE(swing_path(foot, {Hump::place(k), 0, 0}, {}, 0).height, needed[k] - 1e-12);
      highest = std::max(highest, needed[k]);
    }
    EXPECT_LE(hump.height, 1.25 * highest) << "trial " << trial;  // 1 - 0.75^12 = 0.97 at the first sample
    EXPECT_EQ(swing_path(foot, {0, 0, 0}, {}, 0).height, 0);
  }
}

TEST(SwingPath, IsStraightWithoutAHump) {
  BalanceState::FootState foot;
  foot.from[2] = 0.2;
  foot.to[0] = 0.8;
  foot.to[2] = 0.34;
  for (const double s : {0.1, 0.25, 0.9}) EXPECT_NEAR(swing_path(foot, {0.8 * s, 0, 9}, {}, 0.5).height, 0.2 + 0.14 * s, 1e-12);
}

TEST(GroundPlan, FeetSwingAlongASlopeWithoutAHump) {
  const Walker w;
  const Mat3 R = rotation_about({0, 1, 0}, -5 * pi / 180);
  LinkSpec link;
  link.name = "slope";
  link.joint.type = JointType::fixed;
  link.shapes.push_back(Shape::box({20, 20, 0.5}, {R, R * Vec3{0, 0, -0.5}}));
  MechanismSpec spec;
  spec.name = "slope";
  spec.links.push_back(std::move(link));
  const std::vector<MechanismPtr> systems{w.body.mechanism, Mechanism::make(std::move(spec)).value()};
  const auto walk = std::make_shared<const Looped>(w.body.mechanism, motion_of(w.body, w.walk), 5);
  BalanceModel model(w.body.mechanism, walk, {}, 0, GroundMap(systems, 0, -100));
  GroundSupport support(model);
  GroundPlan plan(model);
  BalanceState state;
  state.started = 1;
  state.clock = 1;
  state.feet[1].stands = 1;
  const ScheduledFoot swing = model.schedule.at(0, model.schedule.stances(0)[1].begin - 0.01);
  for (const double phase : {0.0, 0.4}) {
    state.time = swing.begin + phase * (swing.end - swing.begin);
    for (int i = 0; i < 300; ++i) {
      model.sample_reference(state);
      dynamics::update_kinematics(*model.mechanism, model.q_ref, model.v_ref, model.now);
      model.centroid = dynamics::calc_centroidal(*model.mechanism, model.now);
      plan.update(model, support, 0.002, state);
    }
    if (phase == 0) model.lift(0, state);
  }
  ASSERT_GT(state.feet[0].to[2] - state.feet[0].from[2], 0.05);
  EXPECT_LT(state.feet[0].bump, 1e-3);
}

TEST(GroundPlan, BodyIsLoweredForAFootThatLandsLate) {
  // The ground under the left foot is 8 cm lower. The reference already stands on both feet; the left foot has not reached the ground.
  const Walker w;
  const auto stand = std::make_shared<const ChangedStand>(w, 3, [](double, std::span<double>) {});
  LinkSpec link;
  link.name = "ground";
  link.joint.type = JointType::fixed;
  link.shapes.push_back(Shape::box({20, 20, 0.5}, {Mat3::identity(), {0, -20, -0.5}}));
  link.shapes.push_back(Shape::box({20, 20, 0.5}, {Mat3::identity(), {0, 20, -0.08 - 0.5}}));
  MechanismSpec spec;
  spec.name = "ground";
  spec.links.push_back(std::move(link));
  const std::vector<MechanismPtr> systems{w.body.mechanism, Mechanism::make(std::move(spec)).value()};
  BalanceModel model(w.body.mechanism, stand, {}, 0, GroundMap(systems, 0, -100));
  ASSERT_TRUE(model.schedule.at(0, 1).stands && model.schedule.at(1, 1).stands);
  GroundSupport support(model);
  GroundPlan plan(model);
  BalanceState state;
  state.started = 1;
  state.time = state.clock = 1;
  for (std::size_t f = 0; f < 2; ++f) state.feet[f].stands = f != model.left_foot ? 1 : 0;
  model.sample_reference(state);
  std::vector<double> q = model.q_ref;
  dynamics::update_kinematics(*model.mechanism, q, std::vector<double>(model.v_ref.size()), model.now);
  model.centroid = dynamics::calc_centroidal(*model.mechanism, model.now);
  for (int i = 0; i < 500; ++i) {
    plan.update(model, support, 0.002, state);
    model.sample_reference(state);
  }
  EXPECT_NEAR(state.feet[model.left_foot].to[2], -0.08, 1e-3);
  // The legs of the standing reference have their maximum length, so the reference must sink as far as the ground.
  EXPECT_NEAR(state.z - state.lower, -0.08, 0.005);
}

/// A walker in the middle of a swing, on ground that is 10 cm lower behind `edge` (x, m).
struct SwingAtAnEdge {
  Walker w;
  std::unique_ptr<BalanceModel> model;
  std::unique_ptr<GroundSupport> support;
  std::unique_ptr<GroundPlan> plan;
  BalanceState state;
  std::size_t foot = 0;
  ScheduledFoot swing;
  double heel = 0;  // m: x of the rear end of the sole at its landing in the reference

  SwingAtAnEdge() {
    model = make(-1e3);
    swing = model->schedule.at(foot, model->schedule.stances(foot)[1].begin - 0.01);
    heel = 1e9;
    for (const LinkPoint& p : model->feet[foot].points)
      if (p.link == model->feet[foot].link) heel = std::min(heel, (swing.next->foot * p.location.p).x);
  }
  std::unique_ptr<BalanceModel> make(double edge) const {
    LinkSpec link;
    link.name = "ground";
    link.joint.type = JointType::fixed;
    link.shapes.push_back(Shape::box({20, 20, 0.5}, {Mat3::identity(), {edge + 20, 0, -0.5}}));
    link.shapes.push_back(Shape::box({20, 20, 0.5}, {Mat3::identity(), {edge - 20, 0, -0.1 - 0.5}}));
    MechanismSpec spec;
    spec.name = "ground";
    spec.links.push_back(std::move(link));
    const std::vector<MechanismPtr> systems{w.body.mechanism, Mechanism::make(std::move(spec)).value()};
    const auto walk = std::make_shared<const Looped>(w.body.mechanism, motion_of(w.body, w.walk), 5);
    return std::make_unique<BalanceModel>(w.body.mechanism, walk, BalanceOptions{}, 0, GroundMap(systems, 0, -100));
  }
  void put_edge(double x) {
    model = make(x);
    support = std::make_unique<GroundSupport>(*model);
    plan = std::make_unique<GroundPlan>(*model);
    state = {};
    state.started = 1;
    state.feet[1 - foot].stands = 1;
  }
  void go_to(double phase) {
    state.time = swing.begin + phase * (swing.end - swing.begin);
    state.clock = 1;
    model->sample_reference(state);
    dynamics::update_kinematics(*model->mechanism, model->q_ref, model->v_ref, model->now);
    model->centroid = dynamics::calc_centroidal(*model->mechanism, model->now);
    for (int i = 0; i < 300; ++i) plan->update(*model, *support, 0.002, state);
  }
};

TEST(GroundPlan, FootholdsKeepAwayFromEdges) {
  SwingAtAnEdge s;
  // The heel would land 1 cm ahead of the edge: the foothold moves ahead, until the margin is on the same ground.
  s.put_edge(s.heel - 0.01);
  s.go_to(0.3);
  EXPECT_GT(s.state.feet[s.foot].place[0], 0.02);
  EXPECT_LT(s.state.feet[s.foot].place[0], 0.12);
  EXPECT_NEAR(s.state.feet[s.foot].to[2], 0, 1e-3);
  // Far from an edge it stays.
  s.put_edge(s.heel - 0.3);
  s.go_to(0.3);
  EXPECT_EQ(s.state.feet[s.foot].place[0], 0);
}

TEST(GroundPlan, FootholdStaysOnItsStepShortlyBeforeTheLanding) {
  SwingAtAnEdge s;
  const double length = 0.25;  // m, about the length of the foot
  s.put_edge(s.heel + length + 0.07);
  s.go_to(0.3);
  ASSERT_NEAR(s.state.feet[s.foot].to[2], -0.1, 1e-3);
  // At the end of the swing, the balance moves the foot over the riser. It lands in front of the riser.
  s.go_to(0.95);
  for (int i = 0; i < 100; ++i) {
    s.state.feet[s.foot].shift[0] += 0.0013;
    s.plan->update(*s.model, *s.support, 0.002, s.state);
  }
  EXPECT_NEAR(s.state.feet[s.foot].to[2], -0.1, 0.01);
  EXPECT_LT(s.state.feet[s.foot].place[0], -0.01);
}

TEST(BalanceControl, DogTrotsWithoutAssist) {
  const MechanismPtr dog = samples::make_dog();
  const Motion trot = samples::make_dog_trot(*dog);
  Simulation s(dog, std::make_shared<const Looped>(dog, trot, 20));
  for (int i = 0; i < 2500; ++i) {
    s.step();
    if (HasFatalFailure()) return;
    ASSERT_LT(s.below(), 0.2) << "time " << 0.002 * i;
  }
  EXPECT_GT(s.state.q[0], 0.8 * 1.35 * 5);  // m: the trot has a speed of 1.35 m/s
}

}  // namespace
}  // namespace ugoki::control
