#include "ugoki/control/balance_tasks.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "ugoki/control/hang_plan.h"
#include "ugoki/control/swing_path.h"
#include "ugoki/dynamics/jacobian.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::control {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Adds one equation for each direction: the acceleration of the point p of a link. @param target m/s^2, world
void add_point_rows(const BalanceModel& model, int link, const Vec3& p, const Vec3& target, double weight, std::span<const Vec3> directions,
                    QuadraticProgram& program) {
  const std::span<const int> chain = dynamics::chain_of_link(model.now, link);
  const Vec3 bias = dynamics::calc_jacobian_bias(*model.mechanism, model.now, link, dynamics::JacobianFrame::world, p).v;
  for (const Vec3& d : directions) {
    const std::span<double> row = program.add_equation(dot(d, target - bias), 1 / weight);
    const Vec3 moment = cross(p - model.now.p0, d);
    for (const int i : chain) row[at(i)] = dot(model.now.S[at(i)].w, moment) + dot(model.now.S[at(i)].v, d);
  }
}

/// Orientation of a swing foot in the reference, turned with the slope of its foothold. A nearly level sole is made level, because measured
/// soles are tilted by a few degrees in stance.
Mat3 levelled(const BalanceModel& model, const BalanceState::FootState& foot, std::size_t f) {
  const Mat3& R = model.ref.X_WB[at(model.feet[f].link)].R;
  const Vec3 normal = R * model.feet[f].normal, axis = cross(normal, Vec3{0, 0, 1});
  const double tilt = atan2(norm(axis), normal.z);
  const Vec3 ground = normalized(Vec3{-foot.tilt[0], -foot.tilt[1], 1}), slope_axis = cross(Vec3{0, 0, 1}, ground);
  const double slope = norm(slope_axis);
  const Mat3 incline = slope > 1e-9 ? rotation_about(slope_axis / slope, atan2(slope, ground.z)) : Mat3::identity();
  if (tilt < 1e-9 || tilt > model.options.steep) return incline * R;
  const double share = 1 - smooth_step((tilt - model.options.flat) / (model.options.steep - model.options.flat)).value;
  return incline * rotation_about(normalized(axis), tilt * share) * R;
}

/// Adds the task that a link has the orientation R_ref.
void add_turn_task(const BalanceModel& model, int link, const Mat3& R_ref, double frequency, double weight, QuadraticProgram& program) {
  const auto l = at(link);
  const Pose &X = model.now.X_WB[l], &X_ref = model.ref.X_WB[l];
  const Vec3 error = log_map(to_quat(R_ref * X.R.transposed()));
  const std::span<const int> chain = dynamics::chain_of_link(model.now, link);
  Vec3 alpha = dynamics::calc_jacobian_bias(*model.mechanism, model.ref, link, dynamics::JacobianFrame::world, X_ref.p).w;
  for (const int i : dynamics::chain_of_link(model.ref, link)) alpha += model.ref.S[at(i)].w * model.a_ref[at(i)];
  const Vec3 bias = dynamics::calc_jacobian_bias(*model.mechanism, model.now, link, dynamics::JacobianFrame::world, X.p).w;
  const Vec3 target = alpha + error * (frequency * frequency) + (model.ref.V[l].w - model.now.V[l].w) * (2 * frequency) - bias;
  for (int k = 0; k < 3; ++k) {
    const std::span<double> row = program.add_equation(target[k], 1 / weight);
    for (const int i : chain) row[at(i)] = model.now.S[at(i)].w[k];
  }
}

/// Share of the weight of the orientation of a swing foot. On sloping ground, the orientation can be beyond a limit of the foot's joint.
/// Only the leg and the body could turn the foot further, so the share decreases where the joint comes close to a limit.
double turn_share(const BalanceModel& model, const BalanceInput& in, const BalanceState::FootState& memory, const Foot& foot) {
  constexpr double min_share = 0.02, level = 0.05;  // minimum of the share; slope below which the ground counts as partly level
  const double slope = std::min(1.0, norm(Vec3{memory.tilt[0], memory.tilt[1], 0}) / level);
  if (slope == 0) return 1;
  const Link& link = model.mechanism->link(foot.link);
  std::array<double, 6> x{};
  joint_displacement(link.joint, in.q.data() + link.q_index, x.data());
  double margin = model.options.turn_margin;
  for (int k = 0; k < link.joint.nv(); ++k) {
    const Dof& d = model.now.dofs[at(link.v_index + k)];
    margin = std::min({margin, d.upper - x[at(k)], x[at(k)] - d.lower});
  }
  return 1 + slope * (std::max(min_share, margin / model.options.turn_margin) - 1);
}

void add_swing_task(const BalanceModel& model, const BalanceInput& in, std::size_t f, const BalanceState& state,
                    QuadraticProgram& program) {
  const Foot& foot = model.feet[f];
  const BalanceState::FootState& memory = state.feet[f];
  const auto l = at(foot.link);
  const ScheduledFoot planned = model.schedule.at(f, state.time);
  // The phase of a reaction step is measured by BalanceState::clock, not by the time of the reference.
  const double length = memory.reacts ? memory.length : planned.end - planned.begin;
  const double passed = memory.reacts ? state.clock - memory.begin : state.time - planned.begin;
  const bool late = memory.reacts ? passed >= length : planned.stands;
  const double phase = late ? 1 : std::isfinite(length) ? passed / length : 0.5, rate = memory.reacts ? 1 : state.rate;
  SmoothStep s = smooth_step(phase);
  if (!late && std::isfinite(length)) {
    s.rate *= rate / length;
    s.acceleration *= (rate / length) * (rate / length);
  } else {
    s.rate = s.acceleration = 0;
  }
  const Vec3 p = model.now.X_WB[l] * foot.sole, p_ref = model.ref.X_WB[l] * foot.sole;
  Vec3 a = dynamics::calc_jacobian_bias(*model.mechanism, model.ref, foot.link, dynamics::JacobianFrame::world, p_ref).v;
  for (const int i : dynamics::chain_of_link(model.ref, foot.link))
    a += (model.ref.S[at(i)].v + cross(model.ref.S[at(i)].w, p_ref - model.ref.p0)) * model.a_ref[at(i)];
  const Vec3 offset{memory.offset[0], memory.offset[1], memory.offset[2]},
      shift{memory.shift[0] + memory.place[0], memory.shift[1] + memory.place[1], 0};
  const double up = 4 * phase * (1 - phase), down = std::clamp((phase - 0.7) / 0.3, 0.0, 1.0);
  // In flight, the legs keep their posture relative to the centre of mass. Both flights end at the same height.
  const double flight = model.flight(state) ? model.centroid.centre.z - model.want.centre.z : 0;
  Vec3 goal = p_ref + offset * (1 - s.value) + shift * s.value +
              Vec3{0, 0,
                   flight + memory.raise * (1 - down) + (memory.reacts ? model.options.step_clearance : model.options.clearance) * up -
                       model.options.aim_depth * down};
  const Vec3 v_ref = dynamics::point_velocity(model.ref, foot.link, p_ref);
  Vec3 speed = v_ref + (shift - offset) * s.rate;
  // The height of the foot above the ground is that of the reference.
  const Vec3 v = dynamics::point_velocity(model.now, foot.link, p);
  const SwingPath ground = path_over_obstacles(memory, {goal, speed}, {p, v}, phase);
  goal.z += ground.height - model.floor - state.z + state.lower;
  speed.z += ground.rate;
  a += (shift - offset) * s.acceleration;
  const double w = model.options.swing_frequency;
  Vec3 target = a + (goal - p) * (w * w) + (speed - v) * (2 * w);
  if (late) target.z = model.options.sole_damping * (-model.options.press_speed - v.z);
  const Vec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  add_point_rows(model, foot.link, p, target, model.options.swing_weight, axes, program);
  if (foot.turns)
    add_turn_task(model, foot.link, levelled(model, memory, f), w, turn_share(model, in, memory, foot) * model.options.swing_turn_weight,
                  program);
}

/// Adds the task that a foot moves to the place below the body where it will land.
void add_landing_task(const BalanceModel& model, std::size_t f, const BalanceState& state, QuadraticProgram& program) {
  const Foot& foot = model.feet[f];
  const double w = model.options.landing_frequency;
  const Vec3 p = model.now.X_WB[at(foot.link)] * foot.sole, v = dynamics::point_velocity(model.now, foot.link, p);
  const LandingGoal goal = landing_goal(model, state, f);
  const Vec3 target = goal.acceleration + (goal.place - p) * (w * w) + (goal.velocity - v) * (2 * w);
  const Vec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  add_point_rows(model, foot.link, p, target, model.options.landing_weight, axes, program);
  if (foot.turns) add_turn_task(model, foot.link, levelled(model, state.feet[f], f), w, model.options.swing_turn_weight, program);
}

/// Adds the constraint that a gripping point moves with its counterpart on the other side.
void add_grip(const BalanceModel& model, const HeldPoint& h, QuadraticProgram& program) {
  const Vec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const Vec3 slip = dynamics::point_velocity(model.now, h.link, h.p) - h.velocity;
  add_point_rows(model, h.link, h.p, slip * -model.options.sole_damping, model.options.sole_weight, axes, program);
  if (!h.rigid) return;
  const Vec3 bias = dynamics::calc_jacobian_bias(*model.mechanism, model.now, h.link, dynamics::JacobianFrame::world, h.p).w;
  const Vec3 target = (h.turning - model.now.V[at(h.link)].w) * model.options.sole_damping - bias;
  for (int k = 0; k < 3; ++k) {
    const std::span<double> row = program.add_equation(target[k], 1 / model.options.sole_weight);
    for (const int i : dynamics::chain_of_link(model.now, h.link)) row[at(i)] = model.now.S[at(i)].w[k];
  }
}

void add_standing_foot(const BalanceModel& model, const GroundSupport& support, std::size_t f, QuadraticProgram& program) {
  // Rows for each link that bears load: three at the first point, two at the second, one at a third point that is not on their line.
  for (const int link : model.feet[f].parts) {
    const BearingPoint *first = nullptr, *second = nullptr, *third = nullptr;
    double best = 1e-3;
    for (const BearingPoint& b : support.bearing())
      if (b.link == link && !first) first = &b;
    if (!first) continue;
    for (const BearingPoint& b : support.bearing())
      if (b.link == link && norm(b.p - first->p) > best) second = &b, best = norm(b.p - first->p);
    best = 1e-3;
    if (second) {
      const Vec3 along = normalized(second->p - first->p);
      for (const BearingPoint& b : support.bearing())
        if (b.link == link && norm(cross(along, b.p - first->p)) > best) third = &b, best = norm(cross(along, b.p - first->p));
    }
    const auto slow = [&](const BearingPoint* b) {
      return (dynamics::point_velocity(model.now, link, b->p) - b->slide) * -model.options.sole_damping;
    };
    const Vec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    add_point_rows(model, link, first->p, slow(first), model.options.sole_weight, axes, program);
    if (!second) continue;
    const Vec3 along = normalized(second->p - first->p), side = normalized(cross(first->n, along)), up = cross(along, side);
    const Vec3 across[2] = {side, up};
    add_point_rows(model, link, second->p, slow(second), model.options.sole_weight, across, program);
    if (!third) continue;
    const Vec3 out[1] = {normalized(cross(along, third->p - first->p))};
    add_point_rows(model, link, third->p, slow(third), model.options.sole_weight, out, program);
  }
}

}  // namespace

BalanceTasks::BalanceTasks(const BalanceModel& model) : error_(model.v_ref.size()), A_G_(model.v_ref.size()) {}

int BalanceTasks::max_equations(const BalanceModel& model) {
  // Centre of mass, angular momentum, pelvis, chest; then at most 6 for each link of a foot, one for each hovering point,
  // and 6 for each grip
  std::size_t parts = 0, points = 0;
  for (const Foot& foot : model.feet) parts += foot.parts.size(), points += foot.points.size();
  return static_cast<int>(12 + 6 * parts + points + 6 * BalanceInput::max_held);
}

void BalanceTasks::add_posture(const BalanceModel& model, const LegPosture& legs, const BalanceInput& in, const BalanceState& state,
                               QuadraticProgram& program) {
  difference(*model.mechanism, in.q, legs.positions(), error_);
  const std::span<double> weights = program.weights(), centre = program.centre();
  const bool prepares = HangPlan::prepares(model, in, state);
  const double kp = model.options.joint_frequency * model.options.joint_frequency, kd = 2 * model.options.joint_frequency;
  for (std::size_t i = 0; i < error_.size(); ++i) {
    if (i < 6 && static_cast<HangMode>(state.hang) == HangMode::hangs) {  // the body swings freely
      weights[i] = 1e-3;
      centre[i] = 0;
      continue;
    }
    weights[i] = i < 6 ? 1e-3 : model.is_leg[i] ? model.options.leg_weight : model.options.joint_weight;
    if (prepares) weights[i] *= model.options.prepare_posture;
    const double slip = model.v_ref[i] - in.v[i];
    centre[i] = model.a_ref[i] + (kp * (error_[i] + in.dt * slip) + kd * slip) / (1 + in.dt * kd + in.dt * in.dt * kp);
  }
}

void BalanceTasks::add_momentum(BalanceModel& model, const Vec3& acceleration, QuadraticProgram& program) {
  const Mechanism& m = *model.mechanism;
  const std::size_t n = error_.size();
  dynamics::calc_centroidal_matrix(m, model.now, A_G_);
  Vec6 rate_bias = dynamics::calc_centroidal_momentum_rate(m, model.now, {});
  for (const BalanceModel::Carried& load : model.carried) {
    const Vec3 p = model.now.X_WB[at(load.link)] * load.point;
    rate_bias.v += dynamics::calc_jacobian_bias(m, model.now, load.link, dynamics::JacobianFrame::world, p).v * load.mass;
    for (const int i : dynamics::chain_of_link(model.now, load.link))
      A_G_[at(i)].v += (model.now.S[at(i)].v + cross(model.now.S[at(i)].w, p - model.now.p0)) * load.mass;
  }
  for (int k = 0; k < 3; ++k) {
    const std::span<double> row = program.add_equation(acceleration[k] - rate_bias.v[k] / model.mass(), 1 / model.options.com_weight);
    for (std::size_t i = 0; i < n; ++i) row[i] = A_G_[i].v[k] / model.mass();
  }
  const double inertia = (model.centroid.inertia.xx + model.centroid.inertia.yy + model.centroid.inertia.zz) / 3;
  for (int k = 0; k < 3; ++k) {
    const double target =
        model.want_rate.w[k] - model.options.momentum_gain * (model.centroid.momentum.w[k] - model.want.momentum.w[k]) - rate_bias.w[k];
    const std::span<double> row = program.add_equation(target / inertia, 1 / model.options.momentum_weight);
    for (std::size_t i = 0; i < n; ++i) row[i] = A_G_[i].w[k] / inertia;
  }
}

void BalanceTasks::add_release(BalanceModel& model, const ReleasePlan& release, QuadraticProgram& program) {
  dynamics::calc_centroidal_matrix(*model.mechanism, model.now, A_G_);
  const Vec6 rate_bias = dynamics::calc_centroidal_momentum_rate(*model.mechanism, model.now, {});
  constexpr double shortest = 0.04;                     // s: the momentum changes at most as fast as in this time before the release
  Vec3 needed = model.centroid.inertia * release.turn;  // N m s^2: angular momentum times the duration of the flight
  for (std::size_t i = 6; i < error_.size(); ++i) needed += A_G_[i].w * error_[i];
  const double inertia = (model.centroid.inertia.xx + model.centroid.inertia.yy + model.centroid.inertia.zz) / 3;
  for (int k = 0; k < 3; ++k) {
    const double change = needed[k] / release.flight - model.centroid.momentum.w[k];
    const double target = change / std::max(shortest, release.rest) - rate_bias.w[k];
    const std::span<double> row = program.add_equation(target / inertia, 1 / model.options.prepare_weight);
    for (std::size_t i = 0; i < error_.size(); ++i) row[i] = A_G_[i].w[k] / inertia;
  }
}

void BalanceTasks::add_links(const BalanceModel& model, const GroundSupport& support, const BalanceInput& in, const BalanceState& state,
                             QuadraticProgram& program) {
  const BalanceOptions& o = model.options;
  for (const HeldPoint& h : in.held)
    if (h.fixed) add_grip(model, h, program);
  const auto hang = static_cast<HangMode>(state.hang);
  if (hang == HangMode::hangs) return;  // neither trunk nor feet have a goal in the world
  const double upright = hang == HangMode::drops ? o.landing_upright : 1;
  add_turn_task(model, 0, model.ref.X_WB[0].R, o.trunk_frequency, upright * o.pelvis_weight, program);
  if (model.chest >= 0)
    add_turn_task(model, model.chest, model.ref.X_WB[at(model.chest)].R, o.trunk_frequency, upright * o.chest_weight, program);
  for (const HoveringPoint& h : support.hovering()) {
    const double down = std::min(o.hover_speed, h.gap / o.hover_time);
    const Vec3 target{0, 0, -o.sole_damping * (down + dynamics::point_velocity(model.now, h.link, h.p).z)}, up[1] = {{0, 0, 1}};
    add_point_rows(model, h.link, h.p, target, o.hover_weight, up, program);
  }
  for (std::size_t f = 0; f < model.feet.size(); ++f) {
    if (state.feet[f].stands)
      add_standing_foot(model, support, f, program);
    else if ((hang == HangMode::drops || hang == HangMode::lands) && !state.feet[f].reacts)
      add_landing_task(model, f, state, program);
    else
      add_swing_task(model, in, f, state, program);
  }
}

}  // namespace ugoki::control
