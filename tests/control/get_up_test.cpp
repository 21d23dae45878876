#include "ugoki/control/get_up.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "ugoki/control/balance_control.h"
#include "ugoki/control/fall_control.h"
#include "ugoki/control/return_motion.h"
#include "ugoki/control/still_motion.h"
#include "ugoki/dynamics/centroidal.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/samples/samples.h"
#include "ugoki/spatial/elementary.h"
#include "ugoki/world/world.h"

namespace ugoki::control {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }
constexpr double dt = 0.002;

GetUpPlan plan_of(const MechanismPtr& m) {
  const std::optional<BodyPlan> body = body_plan_of(*m);
  EXPECT_TRUE(body);
  return *plan_get_up(m, *body);
}

/// A fixed box of 40 m x 40 m whose top contains the point (0, 0, height). @param slope rad: the top rises along x
MechanismPtr make_ground(double height, double slope) {
  const Mat3 R = rotation_about({0, 1, 0}, -slope);
  LinkSpec link;
  link.name = "ground";
  link.joint.type = JointType::fixed;
  link.shapes.push_back(Shape::box({20, 20, 5}, {R, Vec3{0, 0, height} - R.column(2) * 5.0}));
  MechanismSpec spec;
  spec.name = "ground";
  spec.links.push_back(std::move(link));
  return Mechanism::make(std::move(spec)).value();
}

std::vector<MechanismPtr> systems_of(const MechanismPtr& person, const MechanismPtr& ground) {
  return ground ? std::vector{person, ground} : std::vector{person};
}

/// A person who lies on the front, at rest.
struct Lying {
  MechanismPtr m;
  world::World world;
  world::WorldState state{world};
  world::WorldStepper stepper{world};
  std::vector<collision::ContactPoint> contacts;  // of the last step
  GetUpPlan plan;

  /// @param turn rotation of the body from the upright position @param bend rad: maximum random angle of its joints
  explicit Lying(double height, const Mat3& turn = rotation_about({0, 1, 0}, pi / 2), double bend = 0, unsigned seed = 0,
                 const MechanismPtr& ground = nullptr, double lift = 0)
      : m(samples::make_person(height).value()),
        world(systems_of(m, ground), {.stepper = {}, .ground = {.height = ground ? -20.0 : 0.0}}),
        plan(plan_of(m)) {
    const std::span<double> q = state.q(0);
    std::ranges::copy(plan.flat, q.begin());
    std::mt19937 random(seed);
    std::vector<double> change(at(m->nv()));
    for (const Link& link : m->links()) {
      if (link.joint.type == JointType::floating) continue;
      double from[6];
      joint_displacement(link.joint, plan.flat.data() + link.q_index, from);
      for (int k = 0; k < link.joint.nv(); ++k) {
        const double to = from[k] + bend * (2.0 * static_cast<double>(random()) / 4294967295.0 - 1);
        change[at(link.v_index + k)] = std::clamp(to, link.joint.dofs[at(k)].lower, link.joint.dofs[at(k)].upper) - from[k];
      }
    }
    if (bend > 0) integrate(*m, plan.flat, change, 1, q);
    const Quat r = to_quat(turn);
    q[0] = q[1] = 0;
    q[2] = 0.3 * height + lift;
    q[3] = r.w, q[4] = r.x, q[5] = r.y, q[6] = r.z;
    stepper.load(state);
    for (int i = 0; i < 600; ++i) step({});
  }
  void step(const world::WorldControl& control) {
    ASSERT_EQ(stepper.step(control, dt).status, contact::StepStatus::ok);
    stepper.store(state);
    contacts.assign(stepper.contacts().begin(), stepper.contacts().end());
  }
  /// Height of the centre of mass, m.
  [[nodiscard]] double height() const {
    std::vector<Pose> X(at(m->link_count()));
    calc_poses(*m, state.q(0), X);
    return centre_of_mass(*m, X).z;
  }
};

/// The drives of recovery and balance control, as the LSI `balance control` uses them.
struct Drives {
  FallControl fall;
  FallState memory;
  std::shared_ptr<const ReturnMotion> way;
  std::optional<BalanceControl> balance;
  BalanceState balance_memory;
  std::vector<double> tau, gain, velocity;

  explicit Drives(const Lying& body)
      : fall(body.m, {.get_up = true}, map_of(body)), tau(at(body.m->nv())), gain(tau.size()), velocity(tau.size()) {
    memory.mode = static_cast<std::uint64_t>(FallMode::lie);
  }
  static GroundMap map_of(const Lying& body) { return {body.world.systems(), 0, body.world.options().ground.height}; }
  void step(Lying& body, const std::shared_ptr<const ReferenceMotion>& track) {
    const std::span<const double> q = body.state.q(0), v = body.state.v(0);
    if (balance) {
      std::ranges::fill(gain, 0.0);
      std::ranges::fill(velocity, 0.0);
      balance->step({q, v, body.contacts, 0, dt}, balance_memory, tau);
    } else {
      fall.step(q, v, body.contacts, 0, dt, memory, tau, gain, velocity);
      if (memory.mode == static_cast<std::uint64_t>(FallMode::ready)) {
        way = std::make_shared<const ReturnMotion>(body.m, track, *fall.plan(), 5.0, 0.0);
        balance.emplace(body.m, way, BalanceOptions{}, 0.0, map_of(body));
        balance_memory.time = way->begin();
        const Placement place = way->placement_at(q, balance->feet());
        balance_memory.x = place.x;
        balance_memory.y = place.y;
        balance_memory.heading = place.heading;
        const GroundMap::Point ground = map_of(body).below({q[0], q[1], q[2]});
        balance_memory.z = ground.height;
        for (int k = 0; k < 2; ++k) balance_memory.tilt[k] = -ground.normal[k] / ground.normal.z;
        balance_memory.ground[0] = q[0];
        balance_memory.ground[1] = q[1];
      }
    }
    for (int i = 0; i < 6; ++i) ASSERT_EQ(tau[at(i)] + gain[at(i)], 0) << "a force on the root";
    body.step({tau, gain, velocity});
  }
};

TEST(GetUp, RisesFromTheFrontAndStands) {
  Lying body(1.75);
  const auto track = std::make_shared<const StillMotion>(body.plan.way.back().q);
  Drives drives(body);
  const double stands = body.plan.way.back().centre.z;
  double up = -1;
  for (int i = 0; i < 3500 && !HasFatalFailure(); ++i) {
    drives.step(body, track);
    if (up < 0 && body.height() > 0.95 * stands) up = i * dt;
  }
  EXPECT_GT(up, 0);
  EXPECT_LT(up, 6);
  EXPECT_GT(body.height(), 0.95 * stands);  // 1 s later
}

/// Bodies fall from low height with bent joints, and come to rest in a posture that follows from the physics alone.
TEST(GetUp, RisesFromTheBackAndFromTheSides) {
  const Mat3 front = rotation_about({0, 1, 0}, pi / 2);
  const std::pair<double, Mat3> starts[] = {
      {1.75, rotation_about({0, 1, 0}, -pi / 2)},      {1.75, rotation_about({1, 0, 0}, 1.4) * front},
      {1.75, rotation_about({1, 0, 0}, -2.2) * front}, {1.1, rotation_about({0, 1, 0}, -1.4)},
      {1.1, rotation_about({1, 0, 0}, 1.9) * front},   {2.2, rotation_about({1, 0, 0}, -2.5) * front}};
  unsigned seed = 1;
  for (const auto& [size, turn] : starts) {
    Lying body(size, turn, 0.6, seed++);
    const auto track = std::make_shared<const StillMotion>(body.plan.way.back().q);
    Drives drives(body);
    const double stands = body.plan.way.back().centre.z;
    double up = -1;
    for (int i = 0; i < 3500 && up < 0 && !HasFatalFailure(); ++i) {
      drives.step(body, track);
      if (body.height() > 0.95 * stands) up = i * dt;
    }
    EXPECT_GT(up, 0) << "start " << seed - 1;
    EXPECT_LT(up, 7) << "start " << seed - 1;
  }
}

/// The ground under the body counts, not the floor of the world, which is 20 m lower here.
TEST(GetUp, RisesOnAPlatformAndOnASlope) {
  for (const auto& [height, slope] : {std::pair{0.8, 0.0}, {0.0, 0.07}, {0.0, -0.1}}) {
    Lying body(1.75, rotation_about({0, 1, 0}, pi / 2), 0, 0, make_ground(height, slope), height);
    const auto track = std::make_shared<const StillMotion>(body.plan.way.back().q);
    Drives drives(body);
    const double stands = body.plan.way.back().centre.z;
    double up = -1;
    for (int i = 0; i < 4000 && !HasFatalFailure(); ++i) {
      drives.step(body, track);
      const double ground = height + std::tan(slope) * body.state.q(0)[0];
      if (up < 0 && body.height() - ground > 0.95 * stands) up = i * dt;
      if (i == 3999) EXPECT_GT(body.height() - ground, 0.9 * stands) << height << ", slope " << slope << ", stood up after " << up << " s";
    }
    EXPECT_GT(up, 0) << height << ", slope " << slope;
    EXPECT_LT(up, 6) << height << ", slope " << slope;
  }
}

TEST(GetUp, SameBitsAfterRestore) {
  Lying a(1.75);
  const auto track = std::make_shared<const StillMotion>(a.plan.way.back().q);
  Drives first(a);
  for (int i = 0; i < 600; ++i) first.step(a, track);
  Lying b(1.75);
  Drives second(b);
  second.memory = first.memory;
  std::ranges::copy(a.state.q(0), b.state.q(0).begin());
  std::ranges::copy(a.state.v(0), b.state.v(0).begin());
  const world::WorldState saved = a.state;
  b.contacts = a.contacts;
  for (int i = 0; i < 200; ++i) first.step(a, track);
  b.stepper.load(saved);
  for (int i = 0; i < 200; ++i) second.step(b, track);
  EXPECT_EQ(a.state.hash(), b.state.hash());
}

TEST(GetUpPlan, CentreOfMassIsOverTheSupport) {
  for (const double height : {1.65, 1.95}) {
    const MechanismPtr m = samples::make_person(height).value();
    const GetUpPlan plan = plan_of(m);
    ASSERT_EQ(plan.stage_end.size(), at(GetUpPlan::stage_count));
    const std::optional<BodyPlan> body = body_plan_of(*m);
    std::vector<Pose> X(at(m->link_count()));
    for (std::size_t k = 0; k < plan.way.size(); ++k) {
      calc_poses(*m, plan.way[k].q, X);
      const Vec3 centre = centre_of_mass(*m, X);
      EXPECT_NEAR(centre.x, plan.way[k].centre.x, 1e-12);
      for (int side = 0; side < 2; ++side) {
        const Vec3 ball = X[at(body->place(side, Place::foot).link)] * plan.ball[side];
        EXPECT_NEAR(ball.x, 0, 0.02 * height) << k;
        EXPECT_NEAR(ball.z, 0, 0.02 * height) << k;
        const Effector& hand = body->place(side, Place::hand);
        const double front = (X[at(hand.link)] * hand.point).x;
        if (static_cast<int>(k) > plan.stage_end[GetUpPlan::prone] && static_cast<int>(k) <= plan.stage_end[GetUpPlan::rock])
          EXPECT_LT(centre.x, front) << k;
        if (static_cast<int>(k) > plan.stage_end[GetUpPlan::rock]) {
          EXPECT_LT(centre.x, 0) << k;
          EXPECT_GT(centre.x, -0.12 * height) << k;
        }
      }
    }
  }
}

TEST(GetUpPlan, KeepsTheLimitsOfTheJoints) {
  const MechanismPtr m = samples::make_person(1.75).value();
  const GetUpPlan plan = plan_of(m);
  const auto check = [&](std::span<const double> q) {
    for (const Link& link : m->links()) {
      if (link.joint.type == JointType::floating) continue;
      double x[6];
      joint_displacement(link.joint, q.data() + link.q_index, x);
      for (int k = 0; k < link.joint.nv(); ++k) {
        EXPECT_LE(x[k], link.joint.dofs[at(k)].upper + 1e-9) << link.name;
        EXPECT_GE(x[k], link.joint.dofs[at(k)].lower - 1e-9) << link.name;
      }
    }
  };
  for (const GetUpPosture& p : plan.way) check(p.q);
  for (const auto& roll : plan.roll)
    for (const GetUpPosture& p : roll) check(p.q);
}

TEST(ReturnMotion, IsContinuousAndJoinsTheTrack) {
  const MechanismPtr m = samples::make_person(1.75).value();
  const GetUpPlan plan = plan_of(m);
  std::vector<double> aside = plan.way.back().q;
  displace_root(*m, {2, 1, 0, 0.7}, aside);
  const auto track = std::make_shared<const StillMotion>(aside);
  const ReturnMotion way(m, track, plan, 3, 0);
  EXPECT_LE(way.begin(), 3);
  EXPECT_LT(way.begin(), way.stands());
  EXPECT_LT(way.stands(), way.joins());
  std::vector<double> q(at(m->nq())), last(q.size()), v(at(m->nv())), a(v.size()), d(v.size());
  way.sample(way.begin(), last, v, a);
  std::vector<Pose> X(at(m->link_count()));
  for (double t = way.begin() + 0.01; t < way.joins() + 0.2; t += 0.01) {
    way.sample(t, q, v, a);
    difference(*m, last, q, d);
    for (const double x : d) EXPECT_LT(std::fabs(x), 0.12) << t;
    last = q;
  }
  EXPECT_EQ(last, aside);
}

}  // namespace
}  // namespace ugoki::control
