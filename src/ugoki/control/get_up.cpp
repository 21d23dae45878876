#include "ugoki/control/get_up.h"

#include <algorithm>
#include <cmath>

#include "ugoki/dynamics/centroidal.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/spatial/elementary.h"
#include "ugoki/spatial/heading.h"

namespace ugoki::control {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

constexpr double turned_over =
    -0.2;  // cosine of the angle between the body's front and the direction down: a climbing body has turned over
constexpr double flatten_time = 0.45;                  // s
constexpr double stretch_time = 0.3;                   // s: part of flatten_time in which the posture changes
constexpr double low_share = 0.55;                     // a body lower than this share of the height on the way has collapsed ...
constexpr double low_time = 0.25;                      // s: ... after this time
constexpr double touch = 2e-3;                         // m: only contact points closer than this bear load
constexpr double friction_share = 0.7;                 // of the friction coefficient
constexpr double load_cost = 1e-4;                     // cost of the squared contact forces relative to the squared missing force
constexpr double max_acceleration = 4, max_turn = 15;  // m/s^2, rad/s^2
constexpr double sole_height = 0.022;                  // of the height of the hips: a sole lower than this stands
constexpr double min_lead = 0.022;                     // of the height of the hips: distance of the DCM behind the balls of the feet

double smooth(double s) {
  s = std::clamp(s, 0.0, 1.0);
  return s * s * (3 - 2 * s);
}

Vec3 limited(const Vec3& x, double max_size) {
  const double size = norm(x);
  return size > max_size ? x * (max_size / size) : x;
}

}  // namespace

GetUp::GetUp(MechanismPtr mechanism, const GetUpOptions& options, std::shared_ptr<const GroundMap> ground)
    : mechanism_(std::move(mechanism)), options_(options), ground_(std::move(ground)), body_(body_plan_of(*mechanism_)), ws_(*mechanism_) {
  const Mechanism& m = *mechanism_;
  for (std::vector<double>* x : {&goal_, &next_}) x->resize(at(m.nq()));
  for (std::vector<double>* x : {&error_, &rate_, &gradient_}) x->resize(at(m.nv()));
  supports_.reserve(64);
  support_links_.reserve(64);
  forces_.reserve(64);
  if (!body_ || at(m.nq()) > GetUpState::max_coordinates) return;
  plan_ = plan_get_up(mechanism_, *body_);
  std::vector<Pose> X(at(m.link_count()));
  calc_poses(m, m.neutral(), X);
  chest_front_ = transpose_times(X[at(body_->chest)].R, Vec3{1, 0, 0});
}

Vec3 GetUp::ahead() const {
  const Vec3 left = ws_.X_WB[0].R * transpose_times(body_->rest, Vec3{0, 1, 0});
  return normalized({left.y, -left.x, 0}, {1, 0, 0});
}

Vec3 GetUp::balls() const {
  Vec3 sum;
  for (int side = 0; side < 2; ++side) sum += ws_.X_WB[at(body_->place(side, Place::foot).link)] * plan_->ball[side] * 0.5;
  return sum;
}

void GetUp::start(GetUpPhase phase, std::span<const double> q, GetUpState& state) const {
  state.phase = static_cast<std::uint64_t>(phase);
  state.time = state.low = state.miss = 0;
  state.way = -1;
  std::ranges::copy(q, state.from);
}

void GetUp::change_phase(std::span<const double> q, double dt, GetUpState& state) const {
  const Mat3 root = ws_.X_WB[0].R * body_->rest.transposed();
  const double down = -0.5 * ((ws_.X_WB[at(body_->chest)].R * chest_front_).z + root.column(0).z);
  const auto fail = [&] {
    ++state.tries;
    start(state.tries >= options_.tries ? GetUpPhase::rest : GetUpPhase::flatten, q, state);
  };
  state.time += dt;
  switch (static_cast<GetUpPhase>(state.phase)) {
    case GetUpPhase::begin: start(down > options_.on_front ? GetUpPhase::climb : GetUpPhase::flatten, q, state); break;
    case GetUpPhase::flatten:
      if (state.time < flatten_time) break;
      // To the side on which the body already lies; after a failed try to the other side.
      state.side = (root.column(1).z < 0) != (state.tries % 2 == 1) ? 0 : 1;
      start(down > options_.on_front ? GetUpPhase::climb : GetUpPhase::roll, q, state);
      break;
    case GetUpPhase::roll:
      if (down > options_.on_front)
        start(GetUpPhase::climb, q, state);
      else if (state.time > options_.roll_time)
        fail();
      break;
    case GetUpPhase::climb: {
      const Vec3 centre = dynamics::calc_centroidal(*mechanism_, ws_).centre;
      const double height = centre.z - ground_at(centre);
      const double planned = plan_->way[at(std::max(0, static_cast<int>(state.way)))].centre.z;
      state.low = state.way > plan_->stage_end[GetUpPlan::kneel] && height < low_share * planned ? state.low + dt : 0;
      const bool over = down < turned_over && state.way < plan_->stage_end[GetUpPlan::gather];
      if (over || state.low > low_time || state.time > options_.climb_time) fail();
      break;
    }
    case GetUpPhase::rest: break;
  }
}

const GetUpPosture* GetUp::find_goal(double dt, GetUpState& state) {
  const Mechanism& m = *mechanism_;
  const std::span<const double> from(state.from, at(m.nq()));
  const auto phase = static_cast<GetUpPhase>(state.phase);
  const std::vector<GetUpPosture>& way = plan_->way;
  const int last = static_cast<int>(way.size()) - 1;
  const auto place = [&](double where, std::span<double> out) {
    if (phase == GetUpPhase::flatten) return interpolate(m, from, plan_->flat, smooth(where / stretch_time), out);
    if (phase == GetUpPhase::climb) {
      if (where < 0) return interpolate(m, from, way[0].q, smooth(where + 1), out);
      const int k = std::min(static_cast<int>(where), last - 1);
      return interpolate(m, way[at(k)].q, way[at(k + 1)].q, std::min(1.0, where - k), out);
    }
    std::span<const double> before = from;
    for (const GetUpPosture& p : plan_->roll[state.side]) {
      if (where < p.time) return interpolate(m, before, p.q, smooth(where / p.time), out);
      before = p.q;
      where -= p.time;
    }
    std::ranges::copy(before, out.begin());
  };
  if (phase != GetUpPhase::climb) {
    place(std::max(0.0, state.time - dt), goal_);
    place(state.time, next_);
    return nullptr;
  }
  place(state.way, goal_);
  const int k = state.way < 0 ? 0 : std::min(static_cast<int>(state.way) + 1, last);
  double rate = 1;
  if (state.way > plan_->stage_end[GetUpPlan::gather])
    rate = std::clamp((options_.slow_to - std::fabs(state.miss) / body_->hip_height) / (options_.slow_to - options_.slow_from), 0.1, 1.0);
  state.way = std::min<double>(last, state.way + dt / way[at(k)].time * rate);
  place(state.way, next_);
  return state.way < 0 ? nullptr : &way[at(k)];
}

void GetUp::step(std::span<const double> q, std::span<const double> v, std::span<const collision::ContactPoint> contacts, int system,
                 double dt, GetUpState& state, std::span<double> tau, std::span<double> gain, std::span<double> velocity) {
  dynamics::update_kinematics(*mechanism_, q, v, ws_);
  change_phase(q, dt, state);
  std::ranges::fill(tau, 0.0);
  if (static_cast<GetUpPhase>(state.phase) == GetUpPhase::rest) {
    std::ranges::copy(q, next_.begin());
    goal_ = next_;
  } else {
    const GetUpPosture* goal = find_goal(dt, state);
    add_support(contacts, system, goal, state, tau);
  }
  add_servo(q, v, dt, tau, gain, velocity);
}

bool GetUp::is_ready(std::span<const double> q, std::span<const double> v, const GetUpState& state) {
  if (static_cast<GetUpPhase>(state.phase) != GetUpPhase::climb || state.way < plan_->stage_end[GetUpPlan::rock]) return false;
  dynamics::update_kinematics(*mechanism_, q, v, ws_);
  for (int side = 0; side < 2; ++side) {
    const Effector& foot = body_->place(side, Place::foot);
    const Vec3 sole = ws_.X_WB[at(foot.link)] * foot.point;
    if (sole.z - ground_at(sole) > sole_height * body_->hip_height) return false;
  }
  const dynamics::Centroidal c = dynamics::calc_centroidal(*mechanism_, ws_);
  const double w0 = std::sqrt(norm(options_.gravity) / std::max(0.05, c.centre.z - ground_at(c.centre)));
  return dot(ahead(), c.centre + c.velocity / w0 - balls()) < -min_lead * body_->hip_height;
}

void GetUp::add_support(std::span<const collision::ContactPoint> contacts, int system, const GetUpPosture* goal, GetUpState& state,
                        std::span<double> tau) {
  const Mechanism& m = *mechanism_;
  const dynamics::Centroidal c = dynamics::calc_centroidal(m, ws_);
  dynamics::calc_potential_gradient(m, ws_, options_.gravity, gradient_);
  std::ranges::copy(gradient_, tau.begin());
  supports_.clear();
  support_links_.clear();
  double reach = 0;
  const Vec3 along = heading_of(ws_.X_WB[0].R * body_->rest.transposed());
  for (const collision::ContactPoint& p : contacts) {
    const bool a = p.system_a == system && p.system_b != system, b = p.system_b == system && p.system_a != system;
    if (p.distance > touch || supports_.size() >= 64 || (!a && !b)) continue;
    supports_.push_back({p.p, a ? p.n : -p.n, friction_share * p.friction, 1, along});
    support_links_.push_back(a ? p.link_a : p.link_b);
    reach = std::max(reach, norm(p.p - c.centre));
  }
  if (supports_.empty()) return;
  Vec3 acceleration, turn;
  if (goal) {
    const Vec3 x = ahead();
    const Mat3 heading = Mat3::columns(x, cross(Vec3{0, 0, 1}, x), {0, 0, 1});
    Vec3 wanted = balls() + heading * goal->centre;
    wanted.z = ground_at(balls()) + goal->centre.z;
    state.miss = dot(x, wanted - c.centre);
    acceleration = limited((wanted - c.centre) * options_.centre_gain - c.velocity * options_.centre_damping, max_acceleration);
    turn = limited(log_map(to_quat(heading * goal->root * ws_.X_WB[0].R.transposed())) * options_.turn_gain, max_turn);
  }
  if (static_cast<GetUpPhase>(state.phase) == GetUpPhase::roll) {  // the supports keep the speed of the roll about the trunk's axis
    const Vec3 axis = (ws_.X_WB[0].R * body_->rest.transposed()).column(2) * (state.side == 0 ? 1.0 : -1.0), spin = c.inertia * axis;
    turn = axis * std::clamp(options_.roll_gain * (options_.roll_speed - dot(c.momentum.w, axis) / dot(spin, axis)), -max_turn, max_turn);
  }
  Vec6 wrench{c.inertia * turn, (acceleration - options_.gravity) * m.mass()};
  if (goal) wrench.w -= c.momentum.w * options_.turn_damping;
  forces_.resize(supports_.size());
  problem_.solve(supports_, c.centre, wrench, std::max(0.1, 0.5 * reach), load_cost, forces_);
  for (std::size_t k = 0; k < supports_.size(); ++k)
    for (const int i : dynamics::chain_of_link(ws_, support_links_[k]))
      tau[at(i)] -= dot(ws_.S[at(i)].v + cross(ws_.S[at(i)].w, supports_[k].p - ws_.p0), forces_[k]);
}

void GetUp::add_servo(std::span<const double> q, std::span<const double> v, double dt, std::span<double> tau, std::span<double> gain,
                      std::span<double> velocity) {
  difference(*mechanism_, goal_, next_, rate_);
  difference(*mechanism_, q, next_, error_);
  for (std::size_t i = 0; i < tau.size(); ++i) {
    gain[i] = velocity[i] = 0;
    const double limit = options_.strength * ws_.dofs[i].effort;
    if (i < 6 || !(limit > 0) || !std::isfinite(limit)) {
      tau[i] = 0;
      continue;
    }
    tau[i] = std::clamp(tau[i], -limit, limit);
    const double stiffness = limit / options_.bend;
    gain[i] = stiffness * options_.damping;
    const double wanted = rate_[i] / dt + error_[i] / options_.damping, room = (limit - std::fabs(tau[i])) / gain[i];
    velocity[i] = std::clamp(wanted, v[i] - room, v[i] + room);
  }
}

}  // namespace ugoki::control
