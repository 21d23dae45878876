// Feasible centre of mass of the reference, the DCM ahead of a moving anchor, heels on level ground.

#include "ugoki/control/feasible_centre.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "balance_scene.h"
#include "ugoki/control/ground_support.h"
#include "ugoki/control/reference_anchor.h"
#include "ugoki/control/support_area.h"
#include "ugoki/dynamics/centroidal.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::control {
namespace {

constexpr double frequency = 8, gravity = 9.81;  // rad/s, m/s^2

/// The standing sample human, moved ahead and back along x as a rigid body, for two periods from 1 s on.
class Carried final : public ReferenceMotion {
 public:
  Carried(const Walker& w, double amplitude)
      : m_(w.body.mechanism), stand_(m_, motion_of(w.body, samples::make_human_stand()), 4), amplitude_(amplitude) {}
  void sample(double t, std::span<double> q, std::span<double> v, std::span<double> a) const override {
    stand_.sample(0, q, v, a);
    std::ranges::fill(v, 0.0);
    std::ranges::fill(a, 0.0);
    displace_root(*m_, {place(t), 0, 0, 0}, q);
    const Mat3& P = m_->link(0).joint.X_PJ.R;
    for (int k = 0; k < 3; ++k) {
      v[static_cast<std::size_t>(3 + k)] = transpose_times(P, Vec3{1, 0, 0})[k] * (place(t + 1e-4) - place(t - 1e-4)) / 2e-4;
      a[static_cast<std::size_t>(3 + k)] = transpose_times(P, Vec3{1, 0, 0})[k] * acceleration(t);
    }
  }
  [[nodiscard]] double end() const override { return 4; }
  [[nodiscard]] double place(double t) const { return moves(t) ? amplitude_ * (1 - std::cos(frequency * (t - 1))) : 0; }
  [[nodiscard]] double acceleration(double t) const {
    return moves(t) ? amplitude_ * frequency * frequency * std::cos(frequency * (t - 1)) : 0;
  }

 private:
  [[nodiscard]] static bool moves(double t) { return t > 1 && t < 1 + 4 * pi / frequency; }
  MechanismPtr m_;
  Looped stand_;
  double amplitude_;
};

/// The standing sample human: places along x from its centre of mass.
struct Stand {
  Walker w;
  std::vector<Foot> feet = feet_of(*w.body.mechanism);
  double height = 0, heel = 1e9, toe = -1e9;  // m; heel and toe: ends of the area of the pressure
  explicit Stand(double share) {
    const Mechanism& m = *w.body.mechanism;
    const Carried still(w, 0);
    std::vector<double> q(m.neutral().size()), v(static_cast<std::size_t>(m.nv())), a(v.size());
    still.sample(0, q, v, a);
    std::vector<Pose> X(static_cast<std::size_t>(m.link_count()));
    calc_poses(m, q, X);
    Vec3 centre;
    for (int i = 0; i < m.link_count(); ++i)
      centre += X[static_cast<std::size_t>(i)] * m.link(i).inertia.centre() * (m.link(i).inertia.mass / m.mass());
    height = centre.z;
    for (const Foot& foot : feet) {
      double mean = 0;
      const auto x = [&](const LinkPoint& p) { return (X[static_cast<std::size_t>(p.link)] * p.location.p).x - centre.x; };
      for (const LinkPoint& p : foot.points) mean += x(p) / static_cast<double>(foot.points.size());
      for (const LinkPoint& p : foot.points) {
        heel = std::min(heel, mean + share * (x(p) - mean));
        toe = std::max(toe, mean + share * (x(p) - mean));
      }
    }
  }
};

/// The sample human, moved with an amplitude [m], and its feasible centre of mass. The correction of the pressure has no bound.
struct MovedStand {
  BalanceOptions options = [] {
    BalanceOptions o;
    o.pressure_reach = 1;
    return o;
  }();
  Stand stand{options.sole_share};
  Carried motion;
  FeasibleCentre centre;
  explicit MovedStand(double amplitude)
      : motion(stand.w, amplitude),
        centre(*stand.w.body.mechanism, stand.feet, FootSchedule(*stand.w.body.mechanism, stand.feet, motion, 0), motion, options, 0) {}
};

TEST(FeasibleCentre, IsTheConvolutionOfTheMissingPressureWithThatOfAPendulum) {
  const MovedStand moved(0.02);
  const Stand& s = moved.stand;
  const Carried& motion = moved.motion;
  const FeasibleCentre& centre = moved.centre;
  const double w2 = gravity / s.height, w = std::sqrt(w2), h = 1e-3;
  const auto missing = [&](double t) {
    const double p = -motion.acceleration(t) / w2;
    return std::clamp(p, s.heel, s.toe) - p;
  };
  double largest = 0;
  for (double t = 0.5; t < 3; t += 0.05) {
    double wanted = 0;  // d(t) = integral of w / 2 exp(-w |t - u|) (s - p)(u) over u
    for (double u = 1; u < 1 + 4 * pi / frequency; u += h) wanted += 0.5 * w * std::exp(-w * std::fabs(t - u)) * missing(u) * h;
    EXPECT_NEAR(centre.at(t).position.x, wanted, 1.5e-3) << t;
    EXPECT_NEAR(centre.at(t).position.y, 0, 1e-6);
    largest = std::max(largest, std::fabs(wanted));
  }
  EXPECT_GT(largest, 8e-3) << "the motion needs its pressure outside the soles";
}

TEST(FeasibleCentre, PressureOfTheDisplacedCentreIsOnTheSoles) {
  const MovedStand moved(0.02);
  const Stand& s = moved.stand;
  const Carried& motion = moved.motion;
  const FeasibleCentre& centre = moved.centre;
  constexpr double h = 1.0 / 60;  // s: two frames
  double before = 0;
  for (double t = 0.5; t < 3; t += 0.01) {
    const auto at = [&](double u) { return centre.at(u).position.x; };
    const double acceleration = motion.acceleration(t) + (at(t + h) - 2 * at(t) + at(t - h)) / (h * h);
    const double p = at(t) - acceleration * s.height / gravity;
    const bool jumps = std::fabs(t - 1) < 0.05 || std::fabs(t - 1 - 4 * pi / frequency) < 0.05;  // of the reference's acceleration
    if (!jumps) {
      EXPECT_GT(p, s.heel - 0.01) << t;
      EXPECT_LT(p, s.toe + 0.01) << t;
    }
    before = std::max(before, std::max(s.heel, -motion.acceleration(t) * s.height / gravity) - s.toe);
  }
  EXPECT_GT(before, 0.01) << "without the displacement, the pressure is ahead of the toes";
}

TEST(FeasibleCentre, IsThatOfTheReferenceIfItsPressureIsOnTheSoles) {
  const FeasibleCentre centre = MovedStand(0.001).centre;
  for (double t = 0; t < 5; t += 0.1) EXPECT_EQ(norm(centre.at(t).position) + norm(centre.at(t).acceleration), 0) << t;
}

TEST(SupportArea, DistanceToTheEdgeOfASquareALineAndAPoint) {
  std::vector<Vec3> square = {{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0.5, 0.5, 0}, {0, 1, 0}};
  Vec3 closest;
  EXPECT_NEAR(distance_to_edge(square, {0.3, 0.5, 7}, closest), 0.3, 1e-12);
  std::vector<Vec3> again = {{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}};
  EXPECT_NEAR(distance_to_edge(again, {4, 5, 0}, closest), -5, 1e-12);
  EXPECT_NEAR(norm(closest - Vec3{1, 1, 0}), 0, 1e-12);
  std::vector<Vec3> line = {{0, 0, 0}, {2, 0, 0}};
  EXPECT_NEAR(distance_to_edge(line, {1, 3, 0}, closest), -3, 1e-12);
  std::vector<Vec3> point = {{1, 1, 0}};
  EXPECT_NEAR(distance_to_edge(point, {1, 3, 0}, closest), -2, 1e-12);
}

/// A walker in double support whose feet are farther apart than those of its reference.
TEST(ReferenceAnchor, DcmIsAheadOfAnAnchorThatMovesEvenly) {
  const Walker w;
  BalanceModel model(w.body.mechanism, std::make_shared<const Looped>(w.body.mechanism, motion_of(w.body, w.walk), 5), {}, 0);
  // A double support in the middle of the walk: one foot has landed, the other will lift.
  double begin = 0, end = 0;
  for (double t = 1; t < 3 && end == 0; t += 0.005) {
    const ScheduledFoot a = model.schedule.at(0, t), b = model.schedule.at(1, t);
    if (!a.stands || !b.stands) continue;
    begin = std::max(a.begin, b.begin);
    end = std::min(a.end, b.end);
  }
  ASSERT_GT(end, begin);
  ASSERT_LT(end - begin, model.options.max_transfer);
  BalanceState state;
  state.started = state.feet[0].stands = state.feet[1].stands = 1;
  state.time = begin + 0.4 * (end - begin);
  model.sample_reference(state);
  std::vector<double> q = model.q_ref;
  const Link& hip = w.body.mechanism->link(model.feet[0].hip);
  q[static_cast<std::size_t>(hip.q_index)] += 0.1;
  dynamics::update_kinematics(*model.mechanism, q, model.v_ref, model.now);
  model.centroid = dynamics::calc_centroidal(*model.mechanism, model.now);
  const bool first_is_rear = model.schedule.at(0, state.time).end < model.schedule.at(1, state.time).end;
  Vec3 apart = horizontal(model.sole(0) - model.reference_sole(0));
  ASSERT_GT(norm(apart), 0.02);
  ReferenceAnchor anchor;
  anchor.update(model, 0.002, state);
  // The anchor moves by the offset of the front foot minus that of the rear foot within the double support.
  const Vec3 rate = apart * ((first_is_rear ? -1 : 1) / (end - begin));
  const double w0 = 3.2, rest = end - state.time;
  EXPECT_LT(norm(anchor.ahead(w0) - rate / w0 * (1 - std::exp(-w0 * rest))), 0.05 * norm(anchor.ahead(w0)));
  EXPECT_GT(norm(anchor.ahead(w0)), 0.01);
  state.feet[0].stands = 0;
  anchor.update(model, 0.002, state);
  EXPECT_EQ(norm(anchor.ahead(w0)), 0) << "the anchor stays at a single foot";
}

TEST(GroundSupport, AHeelThatHoversOnLevelGroundIsPressedDownIfThePressureHasToBeThereAndTheReferenceDoesNotLiftIt) {
  const Walker w;
  const Mechanism& m = *w.body.mechanism;
  // @param pressure m: place of the wanted pressure behind the foremost point of the feet
  const auto pressed_heels = [&](double angle_of_reference, double pressure) {
    BalanceModel model(w.body.mechanism, std::make_shared<const Carried>(w, 0), {}, 0);
    BalanceState state;
    state.started = state.feet[0].stands = state.feet[1].stands = 1;
    model.sample_reference(state);
    // The whole body, turned by an angle about y, with its toes on the floor.
    const auto turned = [&](double angle) {
      std::vector<double> q = model.q_ref;
      std::vector<Pose> X(static_cast<std::size_t>(m.link_count()));
      std::vector<double> v(static_cast<std::size_t>(m.nv()));
      const Mat3 pitch = rotation_about({0, 1, 0}, angle);
      calc_poses(m, q, X);
      const Mat3 local = X[0].R.transposed() * pitch * X[0].R;
      const Vec3 axis = log_map(to_quat(local));
      for (int k = 0; k < 3; ++k) v[static_cast<std::size_t>(k)] = axis[k];
      std::vector<double> moved(q.size());
      integrate(m, q, v, 1, moved);
      calc_poses(m, moved, X);
      double low = 1e9;
      for (const Foot& foot : model.feet)
        for (const LinkPoint& p : foot.points)
          low = std::min(low, (X[static_cast<std::size_t>(p.link)] * p.location.p).z - p.location.radius);
      displace_root(m, {0, 0, -low, 0}, moved);
      return moved;
    };
    dynamics::update_kinematics(m, turned(angle_of_reference), model.v_ref, model.ref);
    const std::vector<double> q = turned(0.03);
    dynamics::update_kinematics(m, q, model.v_ref, model.now);
    model.centroid = dynamics::calc_centroidal(m, model.now);
    std::vector<collision::ContactPoint> contacts;
    for (const Foot& foot : model.feet)
      for (const LinkPoint& p : foot.points) {
        const Vec3 place = model.now.X_WB[static_cast<std::size_t>(p.link)] * p.location.p - Vec3{0, 0, p.location.radius};
        if (place.z > 5e-4) continue;
        collision::ContactPoint c;
        c.system_a = 0;
        c.link_a = p.link;
        c.p = {place.x, place.y, 0};
        c.n = {0, 0, 1};
        c.distance = place.z;
        contacts.push_back(c);
      }
    EXPECT_FALSE(contacts.empty());
    double toe = -1e9;
    for (const collision::ContactPoint& c : contacts) toe = std::max(toe, c.p.x);
    GroundSupport support(model);
    support.collect(model, {q, model.v_ref, contacts, 0, 0.002});
    support.find_bearing(model, state, {toe - pressure, 0, 0});
    return std::pair{support.hovering().size(), support.bearing().size()};
  };
  constexpr double behind = 0.1, ahead = -0.05;  // m
  EXPECT_GT(pressed_heels(0, behind).first, 0u);
  EXPECT_EQ(pressed_heels(0.03, behind).first, 0u);
  // A heel that was pressed down now would move the pressure back from the toes, where it has to be.
  EXPECT_EQ(pressed_heels(0, ahead).first, 0u);
  EXPECT_GE(pressed_heels(0, ahead).second, pressed_heels(0, behind).second) << "all points go on bearing load";
}

}  // namespace
}  // namespace ugoki::control
