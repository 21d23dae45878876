// Walks that are disturbed: touches of a swing foot, the way down from an edge, the rate of the reference's time.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "balance_scene.h"
#include "ugoki/control/foot_phase.h"
#include "ugoki/control/swing_path.h"

namespace ugoki::control {
namespace {

/// A walker in its reference's posture at a phase of a swing, raised by a distance. One point of the swinging foot touches the floor.
struct TouchingFoot {
  Walker w;
  std::shared_ptr<const Looped> walk = std::make_shared<const Looped>(w.body.mechanism, motion_of(w.body, w.walk), 5);
  BalanceModel model{w.body.mechanism, walk, {}, 0};
  GroundSupport support{model};
  ScheduledFoot swing = model.schedule.at(0, model.schedule.stances(0)[1].begin - 0.01);

  /// @param height m: of the sole above its height at the landing of the reference @return whether the foot counts as standing
  bool stands(double phase, double height) {
    BalanceState state;
    state.started = state.feet[1].stands = 1;
    state.time = swing.begin + phase * (swing.end - swing.begin);
    model.sample_reference(state);
    std::vector<double> q = model.q_ref;
    const double landing = (swing.next->foot * model.feet[0].sole).z;
    displace_root(*model.mechanism, {0, 0, landing + height - model.reference_sole(0).z, 0}, q);
    dynamics::update_kinematics(*model.mechanism, q, model.v_ref, model.now);
    model.centroid = dynamics::calc_centroidal(*model.mechanism, model.now);
    const Vec3 sole = model.sole(0);
    collision::ContactPoint touch;
    touch.system_a = 0;
    touch.link_a = model.feet[0].link;
    touch.p = {sole.x + 0.1, sole.y, 0};
    touch.n = {0, 0, 1};
    touch.friction = 0.9;
    const collision::ContactPoint contacts[1] = {touch};
    support.collect(model, {q, model.v_ref, contacts, 0, 0.002});
    update_phase(model, support, 0.002, state);
    return state.feet[0].stands != 0;
  }
};

TEST(FootPhase, AFootThatTouchesWithItsToeWhileItsSoleIsHighDoesNotStand) {
  TouchingFoot foot;
  EXPECT_FALSE(foot.stands(0.7, 0.08));
  EXPECT_FALSE(foot.stands(0.95, 0.05));
  EXPECT_TRUE(foot.stands(0.7, 0.01));
  EXPECT_FALSE(foot.stands(0.4, 0.01)) << "in the first half of a swing a foot that touches does not stand";
}

TEST(SwingPath, AFootThatLagsBehindItsGoalStaysOverTheEdge) {
  BalanceState::FootState foot;  // a way of 0.8 m from a platform of 0.1 m, whose edge is near its end
  foot.from[2] = 0.1;
  foot.to[0] = 0.8;
  foot.bump = 0.15;
  foot.sharp[1] = 6;
  const MovingPoint goal{{0.78, 0, 0}, {1.5, 0, 0}}, sole{{0.68, 0, 0}, {2, 0, 0}};
  const SwingPath lagging = path_over_obstacles(foot, goal, sole, 0.95), at_sole = swing_path(foot, sole.p, sole.v, 0.95);
  ASSERT_GT(at_sole.height, swing_path(foot, goal.p, goal.v, 0.95).height + 0.05);
  EXPECT_EQ(lagging.height, at_sole.height);
  EXPECT_EQ(lagging.rate, at_sole.rate);
  // On the way up, the goal is higher than the foot that lags behind it.
  const MovingPoint early_goal{{0.2, 0, 0}, {2, 0, 0}}, early_sole{{0.1, 0, 0}, {2, 0, 0}};
  EXPECT_EQ(path_over_obstacles(foot, early_goal, early_sole, 0.2).height, swing_path(foot, early_goal.p, early_goal.v, 0.2).height);
  // A slope has no hump: the foot swings along it as planned.
  foot.bump = 0;
  EXPECT_EQ(path_over_obstacles(foot, goal, sole, 0.95).height, swing_path(foot, goal.p, goal.v, 0.95).height);
}

/// A plane through the origin that rises along x. @param angle rad
MechanismPtr plane(double angle) {
  const Mat3 R = rotation_about({0, 1, 0}, -angle);
  LinkSpec link;
  link.name = "plane";
  link.joint.type = JointType::fixed;
  link.shapes.push_back(Shape::box({20, 20, 0.5}, {R, R * Vec3{0, 0, -0.5}}));
  MechanismSpec spec;
  spec.name = "plane";
  spec.links.push_back(std::move(link));
  return Mechanism::make(std::move(spec)).value();
}

/// Mean pace within 0.4 s after the begin of a push of 0.1 N s/kg. @param direction unit; x is the direction of the walk
double pace_after_a_push(const MeasuredMotion& motion, const Vec3& direction, double slope) {
  const Walker w;
  Simulation s(w.body, motion, 20, plane(slope));
  const Vec3 push = direction * (0.1 * s.m->mass() / 0.2);
  double sum = 0;
  for (int i = 0; i < 700; ++i) {
    s.step(i >= 500 && i < 600 ? push : Vec3{});
    if (i >= 500) sum += s.memory.pace;
  }
  return sum / 200;
}

TEST(BalanceControl, WalkersOnSlopesThatArePushedBackTakeTheirStepsLater) {
  const Walker w;
  constexpr double slope = 3 * pi / 180;
  const double undisturbed = pace_after_a_push(w.walk, {}, slope);
  EXPECT_LT(pace_after_a_push(w.walk, {-1, 0, 0}, slope), undisturbed - 0.01);
  EXPECT_GT(pace_after_a_push(w.walk, {1, 0, 0}, slope), undisturbed + 0.01);
  // On level ground steps of a changed length correct all errors. A character that stands has no steps to hurry.
  EXPECT_EQ(pace_after_a_push(w.walk, {-1, 0, 0}, 0), 1);
  EXPECT_EQ(pace_after_a_push(samples::make_human_stand(), {1, 0, 0}, slope), 1);
}

}  // namespace
}  // namespace ugoki::control
