#include "ugoki/control/get_up_plan.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "ugoki/control/pose_finder.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::control {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

constexpr double converged = 3e-4;  // rad or m: change of the coordinates with which the inverse kinematics ends

/// Goals of one posture. Lengths in m, angles in rad; a negative weight leaves a goal out.
struct Goals {
  double heel = 0;                            // pitch of the sole: 0 flat, pi / 2 vertical
  double knee = -1;                           // 1: the knees are on the ground, at the distance of tucked toes
  double hip_x = 0, hip_z = 0, hip = -1;      // place of the pelvis and its weight
  double pelvis = 0, chest = 0;               // pitch: 0 upright, pi / 2 face down
  double centre = 0, centre_weight = -1;      // place of the centre of mass ahead of the balls, and its weight
  double hand_x = 0, hand_z = 0, hand_y = 0;  // place of the hands
  double time = 0;
};

Goals blend(const Goals& a, const Goals& b, double s) {
  Goals g = b;
  const auto mix = [s](double x, double y) { return x + s * (y - x); };
  g.heel = mix(a.heel, b.heel);
  g.hip_x = a.hip < 0 ? b.hip_x : mix(a.hip_x, b.hip_x);
  g.hip_z = a.hip < 0 ? b.hip_z : mix(a.hip_z, b.hip_z);
  g.pelvis = mix(a.pelvis, b.pelvis);
  g.chest = mix(a.chest, b.chest);
  g.centre = a.centre_weight < 0 ? b.centre : mix(a.centre, b.centre);
  g.centre_weight = a.centre_weight < 0 || b.centre_weight < 0 ? b.centre_weight : mix(a.centre_weight, b.centre_weight);
  g.hand_x = mix(a.hand_x, b.hand_x);
  g.hand_y = mix(a.hand_y, b.hand_y);
  g.hand_z = mix(a.hand_z, b.hand_z);
  return g;
}

class Planner {
 public:
  Planner(const MechanismPtr& mechanism, const BodyPlan& body)
      : m_(*mechanism), b_(body), finder_(mechanism), feet_(feet_of(m_)), q_(m_.neutral()), X_(at(m_.link_count())) {
    calc_poses(m_, q_, X_);
    for (const Pose& X : X_) rest_.push_back(X.R);
    for (int side = 0; side < 2; ++side) {
      const Foot& foot = *std::ranges::find_if(feet_, [&](const Foot& f) { return f.link == b_.place(side, Place::foot).link; });
      double front = -1e9, back = 1e9, low = 1e9;
      const Pose& X = X_[at(foot.link)];
      for (const LinkPoint& p : foot.points) {
        const Vec3 w = X_[at(p.link)] * p.location.p;
        front = std::max(front, w.x);
        back = std::min(back, w.x - p.location.radius);
        low = std::min(low, w.z - p.location.radius);
      }
      const Vec3 sole = X * foot.sole;
      ball_[at(side)] = X.inverse() * Vec3{front, sole.y, low};
      foot_[at(side)] = foot.link;
      ankle_forward_ = front - X.p.x;
      ankle_height_ = X.p.z - low;
      sole_length_ = front - back;
      const Vec3 hip = X_[at(b_.thigh[at(side)])].p;
      hip_half_ = std::fabs(hip.y - X_[at(b_.thigh[at(1 - side)])].p.y) / 2;
      shank_ = norm(X_[at(b_.place(side, Place::knee).link)].p - X.p);
      shoulder_half_ = std::fabs(X_[at(b_.upper_arm[0])].p.y - X_[at(b_.upper_arm[1])].p.y) / 2;
      trunk_ = X_[at(b_.upper_arm[0])].p.z - hip.z;
      hip_offset_ = hip.z - X_[0].p.z;
      ground_to_hip_ = hip.z - low;
    }
  }

  GetUpPlan run() {
    const double arm = b_.arm_length, thigh = b_.thigh_length, knee_x = ankle_height_ + shank_;
    // From standing backwards to lying, so that each posture is found from its neighbour. The numbers were found by the strategy of
    // usual_roll(): least time until persons of several heights stand.
    Goals stand;
    stand.hip = 1;
    stand.centre_weight = 4;
    stand.centre = -0.5 * sole_length_;
    stand.hip_x = -ankle_forward_;
    stand.hip_z = 0.985 * ground_to_hip_;
    stand.hand_x = -ankle_forward_;
    stand.hand_z = ground_to_hip_ - 0.15 * arm;
    stand.hand_y = hip_half_ + 0.3 * arm;
    stand.time = 0.8;
    Goals squat = stand;
    squat.hip_z = ankle_height_ + 0.97 * shank_;
    squat.hip_x = -ankle_forward_ + 0.58 * shank_ - 1.11 * thigh;
    squat.hip = 0.3;
    squat.pelvis = 0.99;
    squat.chest = 1.22;
    squat.centre = -0.45 * sole_length_;
    squat.hand_x = 0.46 * arm;
    squat.hand_z = -0.01 * arm;
    squat.hand_y = shoulder_half_ + 0.27 * arm;
    squat.time = 0.294;
    Goals rock = squat;
    rock.pelvis = 0.76;
    rock.chest = 1.82;
    rock.heel = -0.14;
    rock.centre = -0.08 * sole_length_;
    rock.hand_x = 0.85 * arm;
    rock.hand_z = 0;
    rock.hip = -1;
    rock.time = 0.447;
    Goals gather = rock;
    gather.heel = 1.31;
    gather.knee = 1;
    gather.pelvis = 0.97;
    gather.chest = 0.99;
    gather.centre_weight = 0.1;
    gather.centre = 0.78 * knee_x;
    gather.hip = 1;
    gather.hip_x = ankle_height_ - 0.10 * shank_;
    gather.hip_z = ankle_forward_ + 0.30 * shank_;
    gather.hand_x = knee_x + 0.25 * arm;
    gather.time = 0.164;
    Goals kneel = gather;
    kneel.hand_x = knee_x + 0.73 * arm;
    kneel.hand_z = 0.02;
    kneel.pelvis = 1.32;
    kneel.chest = 1.45;
    kneel.centre_weight = -1;
    kneel.time = 0.405;
    Goals fours = kneel;
    fours.hip_x = knee_x - 0.15 * thigh;
    fours.hip_z = 0.82 * thigh;
    fours.pelvis = 1.41;
    fours.chest = 1.60;
    fours.hand_x = knee_x + 0.66 * trunk_;
    fours.hand_z = 0;
    fours.time = 0.178;
    Goals prone = fours;
    prone.hip_x = knee_x + thigh;
    prone.hip_z = 0.30 * thigh;
    prone.pelvis = 1.57;
    prone.chest = 1.57;
    prone.hand_z = 0;
    Goals spread = prone;
    spread.hand_x = knee_x + thigh + trunk_ + 0.43 * arm;
    spread.hand_y = shoulder_half_ + 0.66 * arm;
    spread.hand_z = 0.02;
    spread.time = 0.462;
    prone.time = 0.131;
    prone.hand_x = knee_x + thigh + trunk_ - 0.14 * arm;
    prone.hand_y = shoulder_half_ + 0.90 * arm;
    stand.time = 0.484;
    const std::array<Goals, GetUpPlan::stage_count> stages{spread, prone, fours, kneel, gather, rock, squat, stand};
    const std::array<int, GetUpPlan::stage_count> parts{1, 2, 8, 4, 4, 8, 4, 8};
    GetUpPlan plan;
    std::vector<GetUpPosture> reversed;
    // arms down first
    preferred_ = q_;
    q_[2] += stand.hip_z;
    solve(stand, 300);
    preferred_ = q_;
    plan.flat = q_;
    for (int k = GetUpPlan::stage_count - 1; k >= 0; --k) {
      const int n = parts[at(k)];
      for (int j = n; j >= 1; --j) {
        const Goals g = k > 0 ? blend(stages[at(k - 1)], stages[at(k)], static_cast<double>(j) / n) : stages[0];
        solve(g, 60);
        reversed.push_back({q_, stages[at(k)].time / n, centre_, X_[0].R});
      }
    }
    plan.way.assign(reversed.rbegin(), reversed.rend());
    plan.ball[0] = ball_[0];
    plan.ball[1] = ball_[1];
    int end = -1;
    for (const int n : parts) plan.stage_end.push_back(end += n);
    for (int side = 0; side < 2; ++side) plan.roll[side] = roll(side, plan.flat, usual_roll());
    return plan;
  }

 private:
  void solve(const Goals& g, int iterations) {
    const Vec3 y{0, 1, 0};
    for (int i = 0; i < iterations; ++i) {
      finder_.begin(q_);
      const Mat3 sole = rotation_about(y, g.heel);
      for (int side = 0; side < 2; ++side) {
        const double s = side == 0 ? 1 : -1;
        finder_.add_point(foot_[at(side)], ball_[at(side)], {0, s * hip_half_ * 1.2, 0}, {100, 100, 100});
        finder_.add_turn(foot_[at(side)], sole * rest_[at(foot_[at(side)])], 10);
        if (g.knee > 0) {
          const Effector& knee = b_.place(side, Place::knee);
          finder_.add_point(knee.link, knee.point, {ankle_height_ + shank_, s * hip_half_ * 1.2, knee_radius_}, {0, 10, 100});
        }
        const Effector& hand = b_.place(side, Place::hand);
        const bool down = g.hand_z < 0.1;
        finder_.add_point(hand.link, hand.point, {g.hand_x, s * g.hand_y, g.hand_z + hand.radius},
                          down ? Vec3{30, 10, 100} : Vec3{1, 1, 1});
        if (down) finder_.add_axis(hand.link, normalized(hand.point, {1, 0, 0}), normalized(Vec3{1, 0.3 * s, -0.15}), 0.5);
      }
      if (g.hip > 0)
        finder_.add_point(0, {}, {g.hip_x, 0, g.hip_z - hip_offset_}, {3 * g.hip, 10, 3 * g.hip});
      else
        finder_.add_point(0, {}, {0, 0, 0}, {0, 10, 0});
      finder_.add_turn(0, rotation_about(y, g.pelvis) * rest_[0], 1);
      finder_.add_turn(b_.chest, rotation_about(y, g.chest) * rest_[at(b_.chest)], 0.5);
      finder_.add_axis(b_.head, b_.head_up, rotation_about(y, 0.6 * g.chest) * Vec3{0, 0, 1}, 0.1);
      if (g.centre_weight > 0) finder_.add_centre({g.centre, 0, 0}, {30 * g.centre_weight, 0, 0});
      before_ = q_;
      finder_.step(preferred_, 0.003, 0.15, q_);
      double change = 0;
      for (std::size_t k = 0; k < q_.size(); ++k) change = std::max(change, std::fabs(q_[k] - before_[k]));
      if (change < converged) break;
    }
    calc_poses(m_, q_, X_);
    centre_ = centre_of_mass(m_, X_);
  }
  /// Postures that roll the body from its back to one side.
 public:
  std::vector<GetUpPosture> roll(int side, std::span<const double> from, std::span<const RollGoals> parts) {
    std::vector<GetUpPosture> out;
    std::ranges::copy(from, q_.begin());
    calc_poses(m_, q_, X_);
    const std::vector<Pose> X = X_;
    const double s = side == 0 ? 1 : -1;  // direction of the roll, y
    const Vec3 z{0, 0, 1};
    const auto mirrored = [s](const Vec3& x) { return Vec3{x.x, s * x.y, x.z}; };
    const int over = 1 - side, under = side;
    for (const RollGoals& g : parts) {
      for (int i = 0; i < 80; ++i) {
        finder_.begin(q_);
        finder_.add_point(0, {}, X[0].p, {1e3, 1e3, 1e3});
        finder_.add_turn(0, X[0].R, 1e3);
        const auto reach = [&](const Effector& e, const Vec3& from_here, const Vec3& to, double length, double weight) {
          finder_.add_point(e.link, e.point, from_here + mirrored(to) * length, Vec3{1, 1, 1} * weight);
        };
        const Vec3 far_hip = X[at(b_.thigh[at(over)])].p, near_hip = X[at(b_.thigh[at(under)])].p;
        reach(b_.place(over, Place::knee), far_hip, g.far_knee, b_.thigh_length, 1);
        reach(b_.place(over, Place::foot), far_hip, g.far_foot, b_.thigh_length, 1);
        reach(b_.place(under, Place::knee), near_hip, g.near_knee, b_.thigh_length, 1);
        reach(b_.place(under, Place::foot), near_hip, g.near_foot, b_.thigh_length, 1);
        reach(b_.place(over, Place::hand), X[at(b_.upper_arm[at(over)])].p, g.far_hand, b_.arm_length, 1);
        reach(b_.place(under, Place::hand), X[at(b_.upper_arm[at(under)])].p, g.near_hand, b_.arm_length, 1);
        finder_.add_turn(b_.chest, rotation_about(z, g.twist * s) * rest_[at(b_.chest)], 0.5);
        finder_.add_turn(b_.head, rotation_about(z, 1.2 * g.twist * s) * rest_[at(b_.head)], 0.1);
        finder_.step(from, 0.003, 0.2, q_);
      }
      out.push_back({q_, g.time, {}, {}});
    }
    return out;
  }

 private:
  const Mechanism& m_;
  const BodyPlan& b_;
  PoseFinder finder_;
  std::vector<Foot> feet_;
  std::vector<double> q_, before_, preferred_;
  std::vector<Pose> X_;
  std::vector<Mat3> rest_;
  std::array<Vec3, 2> ball_{};
  std::array<int, 2> foot_{};
  double ankle_forward_ = 0, ankle_height_ = 0, sole_length_ = 0, hip_half_ = 0, shank_ = 0, shoulder_half_ = 0, trunk_ = 0,
         hip_offset_ = 0, ground_to_hip_ = 0, knee_radius_ = 0.05;
  Vec3 centre_;
};

}  // namespace

std::array<RollGoals, roll_parts> usual_roll() {
  std::array<RollGoals, roll_parts> r;
  // Found by a separable evolution strategy (CMA-ES, Ros and Hansen 2008) for persons of four heights, each in five lying postures.
  r[0] = {{2.77, -0.56, 0.08},
          {1.27, 0.98, -0.84},
          {1.04, -1.92, 0.26},
          {1.56, -0.42, -2.21},
          {1.85, 0.69, -1.05},
          {-0.63, 0.07, 0.19},
          0.80,
          0.100};
  r[1] = {{0.48, 0.76, -2.07},
          {-3.19, 0.97, -0.31},
          {-1.25, -0.08, -2.59},
          {-0.06, 1.19, -2.12},
          {-1.03, 1.75, 2.28},
          {-0.25, -2.43, 0.78},
          0.80,
          0.100};
  r[2] = {{0.35, 1.18, -1.26},
          {0.42, -1.14, -1.78},
          {-0.25, -0.60, -0.56},
          {-2.54, 1.81, -2.40},
          {0.36, 0.18, 1.85},
          {-0.33, -1.10, 0.77},
          0.20,
          0.325};
  return r;
}

std::vector<GetUpPosture> plan_roll(const MechanismPtr& mechanism, const BodyPlan& body, std::span<const double> from, int side,
                                    std::span<const RollGoals> goals) {
  return Planner(mechanism, body).roll(side, from, goals);
}

std::optional<GetUpPlan> plan_get_up(const MechanismPtr& mechanism, const BodyPlan& body) { return Planner(mechanism, body).run(); }

}  // namespace ugoki::control
