// Walks that are disturbed: touches of a swing foot, the way down from an edge, the rate of the reference's time.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

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

/// The standing sample human, pitched as a whole so that its toes are higher than its heels.
class PitchedStand final : public ReferenceMotion {
 public:
  /// @param angle rad
  PitchedStand(const Walker& w, double angle) : m_(w.body.mechanism), stand_(m_, motion_of(w.body, samples::make_human_stand()), 3) {
    turn_.resize(static_cast<std::size_t>(m_->nv()));
    const Vec3 axis = transpose_times(m_->link(0).joint.X_PJ.R, Vec3{0, -angle, 0});
    for (int k = 0; k < 3; ++k) turn_[static_cast<std::size_t>(k)] = axis[k];
  }
  void sample(double t, std::span<double> q, std::span<double> v, std::span<double> a) const override {
    stand_.sample(t, q, v, a);
    integrate(*m_, q, turn_, 1, q);
  }
  [[nodiscard]] double end() const override { return stand_.end(); }

 private:
  MechanismPtr m_;
  Looped stand_;
  std::vector<double> turn_;
};

/// A character in the posture of its reference, whose lowest points of both soles touch level ground at z = 0.
struct StandingSoles {
  Walker w;
  BalanceModel model;
  GroundSupport support{model};
  BalanceState state;
  double heel = 1e9, toe = -1e9;  // m: x of the ends of the first foot

  /// @param angle rad: pitch of the reference @param edge m: the ground is 2 cm lower at greater x
  StandingSoles(double angle, double edge, const BalanceOptions& options = {})
      : model(w.body.mechanism, std::make_shared<const PitchedStand>(w, angle), options, 0, ground(w, edge)) {
    state.started = state.feet[0].stands = state.feet[1].stands = 1;
    state.time = state.clock = 1;
    model.sample_reference(state);
    std::vector<double> q = model.q_ref;
    move_to(q);
    displace_root(*model.mechanism, {0, 0, -each_point([](const Vec3&, int) {}), 0}, q);
    move_to(q);
    std::vector<collision::ContactPoint> contacts;
    each_point([&](const Vec3& p, int link) {
      if (link == model.feet[0].link) heel = std::min(heel, p.x), toe = std::max(toe, p.x);
      if (p.z > 5e-4 || p.x > edge) return;
      collision::ContactPoint touch;
      touch.system_a = 0;
      touch.link_a = link;
      touch.p = p;
      touch.n = {0, 0, 1};
      touch.friction = 0.9;
      contacts.push_back(touch);
    });
    support.collect(model, {q, model.v_ref, contacts, 0, 0.002});
  }
  /// Number of points that are pressed down if the pressure has to be at the toes.
  std::size_t pressed() {
    support.find_bearing(model, state, {toe, 0, 0});
    return support.hovering().size();
  }

 private:
  static GroundMap ground(const Walker& w, double edge) {
    LinkSpec link;
    link.name = "ground";
    link.joint.type = JointType::fixed;
    link.shapes.push_back(Shape::box({200, 20, 0.5}, {Mat3::identity(), {edge - 200, 0, -0.5}}));
    link.shapes.push_back(Shape::box({200, 20, 0.5}, {Mat3::identity(), {edge + 200, 0, -0.02 - 0.5}}));
    MechanismSpec spec;
    spec.name = "ground";
    spec.links.push_back(std::move(link));
    return {std::vector<MechanismPtr>{w.body.mechanism, Mechanism::make(std::move(spec)).value()}, 0, -100};
  }
  void move_to(std::span<const double> q) {
    dynamics::update_kinematics(*model.mechanism, q, model.v_ref, model.now);
    model.centroid = dynamics::calc_centroidal(*model.mechanism, model.now);
  }
  /// Calls f(lowest point, link) for each point of the soles. @return m: height of the lowest one
  double each_point(const std::function<void(const Vec3&, int)>& f) const {
    double lowest = 1e9;
    for (const Foot& foot : model.feet)
      for (const LinkPoint& point : foot.points) {
        const Vec3 p = model.now.X_WB[static_cast<std::size_t>(point.link)] * point.location.p - Vec3{0, 0, point.location.radius};
        f(p, point.link);
        lowest = std::min(lowest, p.z);
      }
    return lowest;
  }
};

TEST(GroundSupport, ASoleThatLandsOnItsHeelIsPressedDownIfTheLastStepsWereUneven) {
  StandingSoles soles(0.03, 100);  // the reference has its toes 5 mm above its heels
  ASSERT_GT(0.03 * (soles.toe - soles.heel), 0.004);
  EXPECT_EQ(soles.pressed(), 0u) << "level ground: the sole keeps the pitch of the reference";
  soles.state.feet[1].bump = 0.03;  // the other foot swung over an obstacle
  EXPECT_GT(soles.pressed(), 0u);
  // Toes that the reference lifts by more than its errors stay lifted.
  StandingSoles lifted(0.1, 100);  // by 17 mm
  lifted.state.feet[1].bump = 0.03;
  lifted.pressed();
  for (const HoveringPoint& h : lifted.support.hovering()) EXPECT_LT(h.p.x, 0.5 * (lifted.heel + lifted.toe));
}

TEST(GroundSupport, ASoleOnAnEdgeIsNotTippedOverIt) {
  const StandingSoles whole(0, 100);
  const double edge = 0.5 * (whole.heel + whole.toe);
  StandingSoles soles(0, edge);
  EXPECT_EQ(soles.pressed(), 0u);
  BalanceOptions options;
  options.max_gap = 1;
  StandingSoles without(0, edge, options);
  EXPECT_GT(without.pressed(), 0u);
  // A sole whose foothold has the slope of this ground is pressed down.
  for (BalanceState::FootState& foot : soles.state.feet) foot.tilt[0] = -0.3;
  EXPECT_GT(soles.pressed(), 0u);
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
