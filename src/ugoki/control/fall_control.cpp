#include "ugoki/control/fall_control.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/check.h"
#include "ugoki/dynamics/centroidal.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::control {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// Shares of the arm's length: distance of a hand from its shoulder (elbows bent by about 60 degrees), and its part towards the impact.
constexpr double arm_reach = 0.85, towards = 0.7;
// rad/s: maximum speed of the wanted posture. An arm turns by half a turn within 0.3 s.
constexpr double posture_speed = 10;

/// Orientation of the root link in the world.
Mat3 root_turn(const Mechanism& m, std::span<const double> q) {
  const Joint& root = m.link(0).joint;
  return root.X_PJ.R * joint_pose(root, q.data()).R;
}

}  // namespace

FallControl::FallControl(MechanismPtr mechanism, const FallOptions& options, GroundMap ground)
    : mechanism_(std::move(mechanism)),
      options_(options),
      ground_(std::make_shared<const GroundMap>(std::move(ground))),
      plan_(body_plan_of(*mechanism_)),
      ws_(*mechanism_),
      finder_(mechanism_) {
  const Mechanism& m = *mechanism_;
  UGOKI_CHECK(m.link_count() > 0 && m.link(0).joint.type == JointType::floating && at(m.nq()) <= FallState::max_coordinates);
  for (std::vector<double>* x : {&zero_, &error_, &gradient_, &tau_, &gain_, &velocity_}) x->resize(at(m.nv()));
  crouch_ = m.neutral();
  if (!plan_) return;
  for (int side = 0; side < 2; ++side)
    for (int link = plan_->place(side, Place::hand).link; link > plan_->chest; link = m.link(link).parent)
      for (int k = 0; k < m.link(link).joint.nv(); ++k) arms_.push_back(m.link(link).v_index + k);
  // Thighs 45 degrees ahead of the trunk, knees bent by about 90 degrees.
  std::vector<Pose> X(at(m.link_count()));
  calc_poses(m, crouch_, X);
  for (int iteration = 0; iteration < 100; ++iteration) {
    finder_.begin(crouch_);
    finder_.add_point(0, {}, X[0].p, {1e3, 1e3, 1e3});
    finder_.add_turn(0, X[0].R, 1e3);
    for (int side = 0; side < 2; ++side) {
      const Vec3 hip = X[at(plan_->thigh[at(side)])].p, shoulder = X[at(plan_->upper_arm[at(side)])].p;
      const Effector &knee = plan_->place(side, Place::knee), &foot = plan_->place(side, Place::foot),
                     &hand = plan_->place(side, Place::hand);
      const double thigh = plan_->thigh_length, shank = plan_->hip_height - thigh, arm = plan_->arm_length;
      finder_.add_point(knee.link, knee.point, hip + Vec3{0.7 * thigh, 0, -0.7 * thigh}, {1, 1, 1});
      finder_.add_point(foot.link, foot.point, hip + Vec3{0.7 * (thigh - shank), 0, -0.7 * (thigh + shank)}, {1, 1, 1});
      finder_.add_point(hand.link, hand.point, shoulder + Vec3{0.6 * arm, 0, -0.5 * arm}, {1, 1, 1});
    }
    finder_.step(crouch_, 1e-3, 0.1, crouch_);
  }
}

double FallControl::check(std::span<const double> q, std::span<const double> v, std::span<const double> q_ref, const Vec3& dcm_error,
                          double dt, FallState& state) {
  const Mechanism& m = *mechanism_;
  if (state.mode > static_cast<std::uint64_t>(FallMode::brace)) return 0;
  dynamics::update_kinematics(m, q_ref, zero_, ws_);
  const Vec3 planned = dynamics::calc_centroidal(m, ws_).centre;
  dynamics::update_kinematics(m, q, v, ws_);
  const Vec3 centre = dynamics::calc_centroidal(m, ws_).centre;
  const double ground = ground_->below(centre).height, height = centre.z - ground, wanted = std::max(0.05, planned.z - ground);
  const double tilt = acos(std::clamp(dot(root_turn(m, q).row(2), root_turn(m, q_ref).row(2)), -1.0, 1.0));
  const auto exceeds = [&](const FallLimits& limits) {
    return tilt > limits.tilt || height < limits.height * wanted || norm(dcm_error) > limits.reach * wanted;
  };
  const FallLimits& last = options_.fall;
  const double margin =
      1 - std::max({tilt / last.tilt, (1 - height / wanted) / (1 - last.height), norm(dcm_error) / (last.reach * wanted)});
  const bool braces = state.mode == static_cast<std::uint64_t>(FallMode::brace);
  state.time += dt;
  state.trouble = exceeds(braces ? options_.fall : options_.brace) ? state.trouble + dt : 0;
  state.calm = exceeds(options_.brace) ? 0 : state.calm + dt;
  if (state.trouble > options_.delay) {
    if (!braces) std::ranges::copy(q, state.posture);
    state.mode += 1;
  } else if (braces && state.calm > options_.calm) {
    state.mode = static_cast<std::uint64_t>(FallMode::track);
  } else {
    return margin;
  }
  state.time = state.trouble = state.calm = 0;
  return margin;
}

void FallControl::reach_for_the_ground(std::span<const double> q, double dt, FallState& state) {
  const std::span<double> posture(state.posture, at(mechanism_->nq()));
  std::ranges::copy(q.first(7), posture.begin());  // the root of the wanted posture is that of the body
  const Pose root = ws_.X_WB[0];
  const Vec3 chest = ws_.X_WB[at(plan_->chest)].p;
  // The trunk falls in the direction in which the chest moves; at low speed, in the direction in which it leans.
  const Vec3 speed = dynamics::point_velocity(ws_, plan_->chest, chest), lean = chest - root.p;
  const Vec3 direction = normalized({speed.x + 0.5 * lean.x, speed.y + 0.5 * lean.y, 0}, {1, 0, 0});
  finder_.begin(posture);
  finder_.add_point(0, {}, root.p, {1e3, 1e3, 1e3});
  finder_.add_turn(0, root.R, 1e3);
  const Vec3 left = root.R * transpose_times(plan_->rest, Vec3{0, 1, 0});
  for (int side = 0; side < 2; ++side) {
    const Effector& hand = plan_->place(side, Place::hand);
    const Vec3 shoulder = ws_.X_WB[at(plan_->upper_arm[at(side)])].p, outward = left * (side == 0 ? 1.0 : -1.0);
    const Vec3 reach = normalized(direction * towards + Vec3{0, 0, -1} + outward * 0.3);
    Vec3 target = shoulder + reach * (arm_reach * plan_->arm_length);
    target.z = std::max(target.z, ground_->below({target.x, target.y, chest.z}).height + hand.radius);
    finder_.add_point(hand.link, hand.point, target, {1, 1, 1});
  }
  // The head leans away from the impact: chin to chest in a fall backwards, back of the head to the neck in a fall forwards.
  finder_.add_axis(plan_->head, plan_->head_up, normalized(Vec3{0, 0, 1} - direction * 0.7), 0.3);
  finder_.step(crouch_, 0.02, posture_speed * dt, posture);
}

void FallControl::update(std::span<const double> q, std::span<const double> v) {
  dynamics::update_kinematics(*mechanism_, q, v, ws_);
  dynamics::calc_inertia_rows(*mechanism_, ws_);
  dynamics::calc_potential_gradient(*mechanism_, ws_, options_.gravity, gradient_);
}

void FallControl::brace(std::span<const double> q, std::span<const double> v, double dt, FallState& state, std::span<double> tau,
                        std::span<double> gain, std::span<double> velocity) {
  if (state.mode != static_cast<std::uint64_t>(FallMode::brace) || !plan_) return;
  update(q, v);
  reach_for_the_ground(q, dt, state);
  difference(*mechanism_, q, {state.posture, at(mechanism_->nq())}, error_);
  set_posture_servo(ws_, {options_.frequency, 1, 0.5, options_.strength}, dt, v, error_, gradient_, tau_, gain_, velocity_);
  for (const int i : arms_) {
    tau[at(i)] = tau_[at(i)];
    gain[at(i)] = gain_[at(i)];
    velocity[at(i)] = velocity_[at(i)];
  }
}

const GetUpPlan* FallControl::make_plan() {
  if (!get_up_) {
    GetUpOptions options;
    options.gravity = options_.gravity;
    get_up_ = std::make_unique<GetUp>(mechanism_, options, ground_);
  }
  return plan();
}

void FallControl::step(std::span<const double> q, std::span<const double> v, std::span<const collision::ContactPoint> contacts, int system,
                       double dt, FallState& state, std::span<double> tau, std::span<double> gain, std::span<double> velocity) {
  const Mechanism& m = *mechanism_;
  if (state.mode == static_cast<std::uint64_t>(FallMode::lie) && plan_ && options_.get_up && state.time > options_.lie_time &&
      static_cast<GetUpPhase>(state.get_up.phase) != GetUpPhase::rest) {
    state.mode = static_cast<std::uint64_t>(FallMode::rise);
    state.time = 0;
    state.get_up = {};
  }
  if (state.mode >= static_cast<std::uint64_t>(FallMode::rise) && make_plan()) {
    state.time += dt;
    if (static_cast<GetUpPhase>(state.get_up.phase) == GetUpPhase::rest) {  // the tries have failed: it stays on the ground
      state.mode = static_cast<std::uint64_t>(FallMode::lie);
      state.time = 0;
    } else {
      state.mode = static_cast<std::uint64_t>(get_up_->is_ready(q, v, state.get_up) ? FallMode::ready : FallMode::rise);
    }
    get_up_->step(q, v, contacts, system, dt, state.get_up, tau, gain, velocity);
    return;
  }
  update(q, v);
  state.time += dt;
  ServoSettings servo;
  if (state.mode == static_cast<std::uint64_t>(FallMode::fall)) {
    if (plan_) reach_for_the_ground(q, dt, state);
    difference(m, q, {state.posture, at(m.nq())}, error_);
    servo.frequency = options_.frequency;
    servo.gravity_share = 0.5;
    servo.strength = options_.strength;
    state.rest = norm(dynamics::calc_centroidal(m, ws_).velocity) < options_.rest_speed ? state.rest + dt : 0;
    if (state.rest > options_.rest_time) {
      state.mode = static_cast<std::uint64_t>(FallMode::lie);
      state.time = 0;
    }
  } else {
    std::ranges::fill(error_, 0.0);
    servo.frequency = options_.lie_damping;
  }
  set_posture_servo(ws_, servo, dt, v, error_, gradient_, tau, gain, velocity);
}

}  // namespace ugoki::control
