#include "ugoki/control/get_up.h"

#include <algorithm>
#include <cmath>

#include "ugoki/dynamics/centroidal.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::control {
namespace {
std::size_t at(int i) { return static_cast<std::size_t>(i); }
double smooth(double s) {
  s = std::clamp(s, 0.0, 1.0);
  return s * s * (3 - 2 * s);
}
}  // namespace

GetUp::GetUp(MechanismPtr mechanism, const GetUpOptions& options)
    : mechanism_(std::move(mechanism)), options_(options), body_(body_plan_of(*mechanism_)), ws_(*mechanism_) {
  const Mechanism& m = *mechanism_;
  for (std::vector<double>* x : {&goal_, &next_}) x->resize(at(m.nq()));
  for (std::vector<double>* x : {&error_, &rate_, &gradient_}) x->resize(at(m.nv()));
  if (!body_) return;
  plan_ = plan_get_up(mechanism_, *body_);
  std::vector<Pose> X(at(m.link_count()));
  calc_poses(m, m.neutral(), X);
  forward_chest_ = transpose_times(X[at(body_->chest)].R, Vec3{1, 0, 0});
  forward_root_ = transpose_times(X[0].R, Vec3{1, 0, 0});
}

void GetUp::start(GetUpPhase phase, std::span<const double> q, GetUpState& state) const {
  state.phase = static_cast<std::uint64_t>(phase);
  state.time = 0;
  state.sum[0] = state.sum[1] = 0;
  std::ranges::copy(q, state.from);
}

void GetUp::step(std::span<const double> q, std::span<const double> v, std::span<const collision::ContactPoint> contacts, int system,
                 double dt, GetUpState& state, std::span<double> tau, std::span<double> gain, std::span<double> velocity) {
  const Mechanism& m = *mechanism_;
  dynamics::update_kinematics(m, q, v, ws_);
  const GetUpPosture* aim = nullptr;
  const Vec3 front = ws_.X_WB[at(body_->chest)].R * forward_chest_, belly = ws_.X_WB[0].R * forward_root_;
  const double down = -0.5 * (front.z + belly.z);  // 1: on the front, -1: on the back
  state.time += dt;
  auto phase = static_cast<GetUpPhase>(state.phase);
  const auto choose = [&] {
    if (down > 0.4) {
      start(GetUpPhase::climb, q, state);
      state.way = -1;
      return;
    }
    // Rolls towards the side on which it already lies: the left side is lower than the right one.
    const Vec3 left = cross(Vec3{0, 0, 0} + ws_.X_WB[0].R * transpose_times(body_->rest, Vec3{0, 0, 1}), belly);
    state.side = (left.z < 0) != (state.tries % 2 == 1) ? 0 : 1;
    start(GetUpPhase::roll, q, state);
  };
  if (phase == GetUpPhase::begin) choose();
  if (phase == GetUpPhase::roll) {
    if (down > 0.4) {
      choose();
    } else if (state.time > 1.2) {
      ++state.tries;
      start(GetUpPhase::flatten, q, state);
    }
  }
  if (phase == GetUpPhase::flatten && state.time > 0.5) choose();
  phase = static_cast<GetUpPhase>(state.phase);
  const std::span<const double> from(state.from, at(m.nq()));
  if (phase == GetUpPhase::climb) {
    const int last = static_cast<int>(plan_->way.size()) - 1;
    const auto length = [&](int k) { return plan_->way[at(k)].time / options_.pace; };
    const auto place = [&](double way, std::span<double> out) {
      if (way < 0) return interpolate(m, from, plan_->way[0].q, smooth(way + 1), out);
      const int k = std::min(static_cast<int>(way), last - 1);
      interpolate(m, plan_->way[at(k)].q, plan_->way[at(k + 1)].q, std::min(1.0, way - k), out);
    };
    place(state.way, goal_);
    // The way waits while the centre of mass is not over its place.
    double rate = 1;
    if (state.way > plan_->stage_end[GetUpPlan::gather])
      rate = std::clamp((options_.slow_to - std::fabs(miss_.x)) / (options_.slow_to - options_.slow_from), 0.1, 1.0);
    const int k = state.way < 0 ? 0 : std::min(static_cast<int>(state.way) + 1, last);
    state.way = std::min<double>(last, state.way + dt / length(k) * rate);
    place(state.way, next_);
    if (state.way >= 0) aim = &plan_->way[at(k)];
    if (state.way >= last) state.phase = static_cast<std::uint64_t>(GetUpPhase::done);
  } else if (phase == GetUpPhase::done) {
    std::ranges::copy(plan_->way.back().q, goal_.begin());
    next_ = goal_;
    aim = &plan_->way.back();
  } else {
    const std::vector<double>& to = phase == GetUpPhase::roll ? plan_->roll[state.side] : plan_->flat;
    interpolate(m, from, to, smooth((state.time - dt) / 0.35), goal_);
    interpolate(m, from, to, smooth(state.time / 0.35), next_);
  }
  support(contacts, system, aim, dt, state, tau);
  follow(v, dt, q, tau, gain, velocity);
}

bool GetUp::ready(std::span<const double> q, std::span<const double> v) {
  const Mechanism& m = *mechanism_;
  dynamics::update_kinematics(m, q, v, ws_);
  const dynamics::Centroidal c = dynamics::calc_centroidal(m, ws_);
  Vec3 ball;
  double tilt = 0;
  for (int side = 0; side < 2; ++side) {
    const Effector& foot = body_->place(side, Place::foot);
    ball += ws_.X_WB[at(foot.link)] * plan_->ball[side] * 0.5;
    tilt = std::max(tilt, (ws_.X_WB[at(foot.link)] * foot.point).z - options_.ground);
  }
  const Vec3 left = ws_.X_WB[0].R * transpose_times(body_->rest, Vec3{0, 1, 0});
  const Vec3 ahead = normalized({left.y, -left.x, 0}, {1, 0, 0});
  const double w0 = std::sqrt(norm(options_.gravity) / std::max(0.05, c.centre.z - options_.ground));
  const double dcm = dot(ahead, c.centre + c.velocity / w0 - ball);
  return dcm < -0.02 && tilt < 0.02;
}

void GetUp::support(std::span<const collision::ContactPoint> contacts, int system, const GetUpPosture* goal, double dt,
                    GetUpState& state, std::span<double> tau) {
  const Mechanism& m = *mechanism_;
  const dynamics::Centroidal c = dynamics::calc_centroidal(m, ws_);
  dynamics::calc_potential_gradient(m, ws_, options_.gravity, gradient_);
  supports_.clear();
  support_links_.clear();
  double lever = 0;
  for (const collision::ContactPoint& p : contacts) {
    if (p.distance > 2e-3 || supports_.size() >= 64) continue;
    const bool a = p.system_a == system && p.system_b != system, b = p.system_b == system && p.system_a != system;
    if (!a && !b) continue;
    supports_.push_back({p.p, a ? p.n : -p.n, 0.7 * p.friction, 1});
    support_links_.push_back(a ? p.link_a : p.link_b);
    lever = std::max(lever, norm(p.p - c.centre));
  }
  Vec3 acceleration, turn;
  const Vec3 spin = c.inertia.matrix() * Vec3{} + c.momentum.w;
  if (goal) {
    const Vec3 ball = (ws_.X_WB[at(body_->place(0, Place::foot).link)] * plan_->ball[0] +
                       ws_.X_WB[at(body_->place(1, Place::foot).link)] * plan_->ball[1]) *
                      0.5;
    // Heading: the direction to the right of the pelvis turned by 90 degrees.
    const Vec3 left = ws_.X_WB[0].R * transpose_times(body_->rest, Vec3{0, 1, 0});
    const Vec3 ahead = normalized({left.y, -left.x, 0}, {1, 0, 0});
    const Mat3 heading = Mat3::columns(ahead, cross(Vec3{0, 0, 1}, ahead), {0, 0, 1});
    Vec3 wanted = ball + heading * goal->centre;
    wanted.z = options_.ground + goal->centre.z;
    miss_ = transpose_times(heading, wanted - c.centre);
    acceleration = (wanted - c.centre) * options_.centre_gain - c.velocity * options_.centre_damping;
    if (state.way > plan_->stage_end[GetUpPlan::gather] || state.phase == static_cast<std::uint64_t>(GetUpPhase::done)) {
      state.sum[0] = std::clamp(state.sum[0] + miss_.x * dt, -0.15, 0.15);
      state.sum[1] = std::clamp(state.sum[1] + miss_.y * dt, -0.15, 0.15);
    }
    acceleration += heading * Vec3{state.sum[0], state.sum[1], 0} * options_.centre_memory;
    const double size = norm(acceleration);
    if (size > 4) acceleration *= 4 / size;
    turn = log_map(to_quat(heading * goal->root * ws_.X_WB[0].R.transposed())) * options_.turn_gain;
    const double t = norm(turn);
    if (t > 15) turn *= 15 / t;
  }
  Vec6 wrench{c.inertia * turn - spin * options_.turn_damping, (acceleration - options_.gravity) * m.mass()};
  forces_.resize(supports_.size());
  std::ranges::copy(gradient_, tau.begin());
  if (supports_.empty()) return;
  problem_.solve(supports_, c.centre, wrench, std::max(0.1, 0.5 * lever), 1e-4, forces_);
  for (std::size_t k = 0; k < supports_.size(); ++k)
    for (const int i : dynamics::chain_of_link(ws_, support_links_[k]))
      tau[at(i)] -= dot(ws_.S[at(i)].v + cross(ws_.S[at(i)].w, supports_[k].p - ws_.p0), forces_[k]);
}

void GetUp::follow(std::span<const double> v, double dt, std::span<const double> q, std::span<double> tau, std::span<double> gain,
                   std::span<double> velocity) {
  const Mechanism& m = *mechanism_;
  difference(m, goal_, next_, rate_);
  difference(m, q, next_, error_);
  for (std::size_t i = 0; i < tau.size(); ++i) {
    gain[i] = velocity[i] = 0;
    if (i < 6) {
      tau[i] = 0;
      continue;
    }
    const double limit = options_.strength * ws_.dofs[i].effort;
    if (!std::isfinite(limit)) continue;
    tau[i] = std::clamp(tau[i], -limit, limit);
    const double kp = limit / options_.bend, kd = kp * options_.damping;
    // kp (error - dt (v' - wanted rate)) - kd (v' - wanted rate), implicit in v'
    gain[i] = kd;
    const double wanted = rate_[i] / dt + kp * error_[i] / kd, room = (limit - std::fabs(tau[i])) / gain[i];
    velocity[i] = std::clamp(wanted, v[i] - room, v[i] + room);
  }
}

}  // namespace ugoki::control
