#include "ugoki/control/balance_control.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/check.h"
#include "ugoki/dynamics/jacobian.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion/clip.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::control {
namespace {

constexpr std::size_t max_bearing = 64, max_limits = 24;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

Vec3 horizontal(const Vec3& x) { return {x.x, x.y, 0}; }

/// Smooth step from 0 to 1 and its first two derivatives.
struct SmoothStep {
  double value = 0, rate = 0, acceleration = 0;
};
SmoothStep smooth_step(double x) {
  if (x <= 0) return {0, 0, 0};
  if (x >= 1) return {1, 0, 0};
  return {x * x * x * (10 + x * (6 * x - 15)), 30 * x * x * (1 - x) * (1 - x), 60 * x * (1 - x) * (1 - 2 * x)};
}

/// Factor on the shift of a touch-down. It is above 1 because the anchor moves to the new foot only during the following double support.
/// With x = w0 * (duration of the double support) and the error E at touch-down, the error at the end of the double support is E e^x -
/// shift (e^x - 1) / x. This error is zero for shift = factor * E.
double transfer_factor(double x) { return x < 1e-3 ? 1 + 0.5 * x : x * exp(x) / (exp(x) - 1); }

}  // namespace

BalanceControl::BalanceControl(MechanismPtr mechanism, std::shared_ptr<const ReferenceMotion> reference, const BalanceOptions& options,
                               double floor)
    : mechanism_(std::move(mechanism)),
      motion_(std::move(reference)),
      options_(options),
      feet_(feet_of(*mechanism_)),
      schedule_(*mechanism_, feet_, *motion_, floor),
      floor_(floor),
      ws_(*mechanism_),
      ref_(*mechanism_) {
  const Mechanism& m = *mechanism_;
  UGOKI_CHECK(m.link_count() > 0 && m.link(0).joint.type == JointType::floating && feet_.size() <= BalanceState::max_feet);
  const auto nv = at(m.nv());
  q_ref_.resize(at(m.nq()));
  for (std::vector<double>* v : {&v_ref_, &a_ref_, &wanted_, &bias_, &displacement_, &error_}) v->resize(nv);
  A_G_.resize(nv);
  columns_.resize(nv);
  is_leg_.resize(nv);
  part_of_.assign(at(m.link_count()), -1);
  touching_.resize(feet_.size());
  bearing_.reserve(max_bearing);
  limited_.reserve(max_limits);
  hull_.reserve(4 * max_bearing);
  for (std::size_t f = 0; f < feet_.size(); ++f) {
    for (const int d : feet_[f].dofs) is_leg_[at(d)] = 1;
    for (const int link : feet_[f].parts) part_of_[at(link)] = static_cast<int>(f);
  }
  for (int i = 0; i < m.link_count(); ++i)
    if (m.link(i).label == "chest") chest_ = i;
  weight_ = m.mass() * norm(options_.gravity);
  // Rows of the program: centre of mass, angular momentum, pelvis, chest; then at most 6 for each foot or link of a foot
  int parts = 0;
  for (const Foot& foot : feet_) parts += static_cast<int>(foot.parts.size());
  program_.reserve(m.nv(), 4 * static_cast<int>(max_bearing), 12 + 6 * parts, 6 + static_cast<int>(max_limits));
  std::vector<Pose> X(at(m.link_count()));
  calc_poses(m, m.neutral(), X);
  rest_pelvis_ = X[0].R;
  for (std::size_t f = 1; f < feet_.size(); ++f)
    if (X[at(feet_[f].link)].p.y > X[at(feet_[left_foot_].link)].p.y) left_foot_ = f;
}

void BalanceControl::sample_reference(const BalanceState& state) {
  const Mechanism& m = *mechanism_;
  motion_->sample(state.time, q_ref_, v_ref_, a_ref_);
  displace_root(m, {state.x, state.y, 0, state.heading}, q_ref_);
  const Joint& root = m.link(0).joint;
  const Mat3 turn = root.X_PJ.R.transposed() * rotation_about({0, 0, 1}, state.heading) * root.X_PJ.R;
  for (std::vector<double>* x : {&v_ref_, &a_ref_}) {
    const Vec3 linear = turn * Vec3{(*x)[3], (*x)[4], (*x)[5]};
    for (int k = 0; k < 3; ++k) (*x)[at(3 + k)] = linear[k];
  }
  for (double& v : v_ref_) v *= state.rate;
  for (double& a : a_ref_) a *= state.rate * state.rate;
  dynamics::update_kinematics(m, q_ref_, v_ref_, ref_);
  // The wanted velocity of the centre of mass is the velocity at rate 1, also while the time of the reference runs faster or slower.
  want_ = dynamics::calc_centroidal(m, ref_);
  want_rate_ = dynamics::calc_centroidal_momentum_rate(m, ref_, a_ref_) * (1 / (state.rate * state.rate));
  want_.velocity = want_.velocity / state.rate;
  want_.momentum = want_.momentum * (1 / state.rate);
}

void BalanceControl::find_bearing(const BalanceInput& in, const BalanceState& state) {
  bearing_.clear();
  for (const collision::ContactPoint& c : in.contacts) {
    if (c.system_a != in.system || c.system_b >= 0 || bearing_.size() == max_bearing) continue;
    const int foot = part_of_[at(c.link_a)];
    if (foot < 0 || !state.feet[foot].stands) continue;
    if (c.distance > options_.touch) continue;
    const Vec3 p_ref = ref_.X_WB[at(c.link_a)] * (ws_.X_WB[at(c.link_a)].inverse() * c.p);
    const double rise = dot(c.n, dynamics::point_velocity(ref_, c.link_a, p_ref)) / state.rate;
    bearing_.push_back({foot, c.link_a, c.p, c.n, c.friction, dot(c.n, p_ref), rise});
  }
  for (std::size_t f = 0; f < feet_.size(); ++f) {
    double slowest = 1e9, lowest = 1e9;
    for (const Bearing& b : bearing_) {
      if (b.foot != static_cast<int>(f)) continue;
      slowest = std::min(slowest, b.rise);
      lowest = std::min(lowest, b.height);
    }
    std::erase_if(bearing_, [&](const Bearing& b) {
      return b.foot == static_cast<int>(f) &&
             (b.rise > slowest + options_.lifting || (b.height > lowest + options_.lifted && b.rise > slowest + 0.02));
    });
  }
}

void BalanceControl::update_phase(const BalanceInput& in, BalanceState& state) {
  std::ranges::fill(touching_, 0);
  for (const collision::ContactPoint& c : in.contacts)
    if (c.system_a == in.system && c.system_b < 0 && c.distance <= options_.touch && part_of_[at(c.link_a)] >= 0)
      ++touching_[at(part_of_[at(c.link_a)])];
  state.rate = 1;
  for (std::size_t f = 0; f < feet_.size(); ++f) {
    BalanceState::FootState& foot = state.feet[f];
    const ScheduledFoot planned = schedule_.at(f, state.time);
    if (!state.started) foot.stands = planned.stands && touching_[f] > 0;
    if (foot.stands) {
      foot.lost = touching_[f] > 0 ? 0 : foot.lost + in.dt;
      if (planned.stands) foot.early = 0;
      if ((!planned.stands && !foot.early) || foot.lost > 0.02) {
        lift(f, state);
      }
    } else if (foot.reacts) {
      if (!planned.stands || state.clock > foot.begin + foot.length + 0.3)
        foot.reacts = 0;  // the step ends: the reference lifts the foot, or the foot is pressed down until it touches the ground
      if (touching_[f] > 0 && state.clock > foot.begin + options_.early * foot.length) {
        foot.stands = 1;
        foot.reacts = foot.early = 0;
        foot.lost = 0;
      }
    } else {
      const double swing = planned.stands ? 1 : (state.time - planned.begin) / (planned.end - planned.begin);
      if (touching_[f] > 0 && swing > options_.early) {
        foot.stands = 1;
        foot.early = planned.stands ? 0 : 1;
        foot.lost = 0;
      }
    }
    if (foot.early) state.rate = options_.early_rate;
    if (options_.hurry > 0 && !foot.stands && !planned.stands && !foot.reacts && state.rate == 1) {
      const double shift = norm(Vec3{foot.shift[0], foot.shift[1], 0});
      state.rate = std::clamp(1 + options_.hurry * (shift - options_.hurry_from), 1.0, options_.max_hurry);
    }
  }
  for (std::size_t f = 0; f < feet_.size(); ++f)
    if (!state.feet[f].stands && !state.feet[f].reacts && schedule_.at(f, state.time).stands) state.rate = options_.late_rate;
  state.started = 1;
}

void BalanceControl::lift(std::size_t f, BalanceState& state) {
  BalanceState::FootState& foot = state.feet[f];
  foot.stands = foot.early = foot.reacts = 0;
  const Vec3 p = ws_.X_WB[at(feet_[f].link)] * feet_[f].sole - ref_.X_WB[at(feet_[f].link)] * feet_[f].sole;
  for (int k = 0; k < 3; ++k) foot.offset[k] = p[k];
  foot.shift[0] = foot.shift[1] = 0;
}

double BalanceControl::distance_to_support(int foot, const BalanceInput& in, const BalanceState& state, const Vec3& p, Vec3& closest) {
  hull_.clear();
  for (const collision::ContactPoint& c : in.contacts) {
    if (c.system_a != in.system || c.system_b >= 0 || c.distance > 0.01 || hull_.size() == max_bearing) continue;
    const int f = part_of_[at(c.link_a)];
    if (f < 0 || !state.feet[f].stands || (foot >= 0 && f != foot)) continue;
    hull_.push_back(horizontal(c.p));
  }
  closest = p;
  if (hull_.empty()) return -1e3;
  // Convex hull by the monotone chain (Andrew 1979), counter-clockwise, stored in hull_ after the points.
  std::sort(hull_.begin(), hull_.end(), [](const Vec3& a, const Vec3& b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
  const std::size_t n = hull_.size();
  const auto turn = [](const Vec3& o, const Vec3& a, const Vec3& b) { return (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x); };
  for (int pass = 0; pass < 2; ++pass) {
    const std::size_t start = hull_.size();
    for (std::size_t k = 0; k < n; ++k) {
      const Vec3 q = hull_[pass == 0 ? k : n - 1 - k];
      while (hull_.size() >= start + 2 && turn(hull_[hull_.size() - 2], hull_.back(), q) <= 0) hull_.pop_back();
      hull_.push_back(q);
    }
    hull_.pop_back();
  }
  const std::size_t corners = hull_.size() - n;
  double inside = 1e3, best = 1e300;
  const Vec3 flat = horizontal(p);
  for (std::size_t k = 0; k < std::max<std::size_t>(1, corners); ++k) {
    const Vec3 a = corners ? hull_[n + k] : hull_[0], b = corners ? hull_[n + (k + 1) % corners] : hull_[0];
    const Vec3 edge = b - a;
    const double length = norm(edge);
    const double s = length > 0 ? std::clamp(dot(flat - a, edge) / (length * length), 0.0, 1.0) : 0;
    const Vec3 q = a + edge * s;
    if (norm(flat - q) < best) {
      best = norm(flat - q);
      closest = q;
    }
    inside = std::min(inside, length > 0 ? turn(a, b, flat) / length : -best);
  }
  if (corners < 3 || inside < 0) return -best;
  closest = flat;
  return inside;
}

void BalanceControl::update_reactions(const BalanceInput& in, BalanceState& state, double w0) {
  bool all_stand = true;
  double next_lift = 1e300;
  for (std::size_t f = 0; f < feet_.size(); ++f) {
    const ScheduledFoot planned = schedule_.at(f, state.time);
    all_stand = all_stand && state.feet[f].stands && planned.stands;
    if (planned.stands) next_lift = std::min(next_lift, (planned.end - state.time) / state.rate);
  }
  if (!all_stand || feet_.size() != 2 || next_lift < 0.2) {
    state.trouble = 0;
    return;
  }
  const Vec3 dcm = horizontal(now_.centre + now_.velocity / w0), wanted = horizontal(want_.centre + want_.velocity / w0);
  const Vec3 error = dcm - wanted;
  Vec3 edge;
  const double margin = distance_to_support(-1, in, state, dcm, edge);
  state.trouble =
      margin < -options_.step_margin * norm(horizontal(want_.velocity)) && norm(error) > options_.step_error ? state.trouble + in.dt : 0;
  // In the neutral position, the pelvis faces x and its left is y.
  const Vec3 left = normalized(horizontal(ws_.X_WB[0].R * transpose_times(rest_pelvis_, Vec3{0, 1, 0})), {0, 1, 0});
  const auto place = [&](std::size_t f) { return horizontal(ws_.X_WB[at(feet_[f].link)] * feet_[f].sole); };
  const auto offset = [&](std::size_t f) { return place(f) - horizontal(ref_.X_WB[at(feet_[f].link)] * feet_[f].sole); };
  if (state.trouble <= options_.step_delay) return;
  const double grow = exp(w0 * options_.step_time);
  double min_cost = 1e300;
  std::size_t swing = 0;
  Vec3 chosen;
  for (std::size_t f = 0; f < 2; ++f) {
    const std::size_t other = 1 - f;
    Vec3 p;
    distance_to_support(static_cast<int>(other), in, state, dcm, p);
    Vec3 shift = p + (dcm - p) * grow - wanted - offset(other);  // m, relative to the reference as displaced to the other, standing foot
    // The feet must not cross.
    const double side = f == left_foot_ ? 1 : -1;
    const Vec3 landing = horizontal(ref_.X_WB[at(feet_[f].link)] * feet_[f].sole) + offset(other) + shift;
    const double apart = side * dot(landing - place(other), left);
    const double crossing = std::max(0.0, options_.separation - apart);
    shift += left * (side * crossing);
    const double cost = norm(landing - place(f)) + 3 * crossing;
    if (cost < min_cost) {
      min_cost = cost;
      swing = f;
      chosen = shift;
    }
  }
  lift(swing, state);
  BalanceState::FootState& foot = state.feet[swing];
  foot.reacts = 1;
  foot.begin = state.clock;
  foot.length = options_.step_time;
  if (norm(chosen) > options_.max_shift) chosen = chosen * (options_.max_shift / norm(chosen));
  foot.shift[0] = chosen.x;
  foot.shift[1] = chosen.y;
  state.trouble = 0;
}

void BalanceControl::update_anchor(const BalanceInput& in, BalanceState& state) {
  // During double support the anchor moves to the foot that landed last.
  int standing = 0;
  double last_begin = -1e300, first_end = 1e300;
  std::size_t last = 0;
  for (std::size_t f = 0; f < feet_.size(); ++f) {
    if (!state.feet[f].stands) continue;
    ++standing;
    const ScheduledFoot planned = schedule_.at(f, state.time);
    const double begin = planned.stands ? planned.begin : state.time;
    if (begin > last_begin) last_begin = begin, last = f;
    if (planned.stands) first_end = std::min(first_end, planned.end);
  }
  anchor_rate_ = {};
  anchor_rest_ = 0;
  if (standing == 0) return;
  double lead = 1, lead_rate = 0;
  if (standing > 1) {
    const double length = first_end - last_begin;
    lead = std::isfinite(length) && length > 0 ? std::clamp((state.time - last_begin) / length, 0.0, 1.0) : 1.0 / standing;
    if (std::isfinite(length) && length > 0 && lead < 1) lead_rate = state.rate / length;
  }
  Vec3 shift, centre;
  double turn = 0;
  for (std::size_t f = 0; f < feet_.size(); ++f) {
    if (!state.feet[f].stands) continue;
    const double share = standing == 1 ? 1 : f == last ? lead : (1 - lead) / (standing - 1);
    const Pose &X = ws_.X_WB[at(feet_[f].link)], &X_ref = ref_.X_WB[at(feet_[f].link)];
    const Vec3 offset = X * feet_[f].sole - X_ref * feet_[f].sole;
    shift += offset * share;
    if (standing > 1) anchor_rate_ += horizontal(offset) * (f == last ? lead_rate : -lead_rate / (standing - 1));
    centre += (X_ref * feet_[f].sole) * share;
    const Vec3 rotation = log_map(to_quat(X.R * X_ref.R.transposed()));
    turn += rotation.z * share;
  }
  if (standing > 1) anchor_rest_ = std::max(0.0, first_end - state.time) / state.rate;
  const double follow = std::min(1.0, in.dt / options_.anchor_time);
  const double angle = options_.heading_time > 0 ? turn * std::min(1.0, in.dt / options_.heading_time) : 0;
  // Rotates the reference about its standing foot, then translates it.
  const Vec3 pivot = horizontal(centre), moved = pivot - rotation_about({0, 0, 1}, angle) * pivot + horizontal(shift) * follow;
  const Placement next = Placement{moved.x, moved.y, 0, angle} * Placement{state.x, state.y, 0, state.heading};
  state.x = next.x;
  state.y = next.y;
  state.heading = next.heading;
}

void BalanceControl::add_point_rows(int link, const Vec3& p, const Vec3& target, double weight, std::span<const Vec3> directions) {
  const std::span<const int> chain = dynamics::chain_of_link(ws_, link);
  const Vec3 bias = dynamics::calc_jacobian_bias(*mechanism_, ws_, link, dynamics::JacobianFrame::world, p).v;
  for (const Vec3& d : directions) {
    const std::span<double> row = program_.add_equation(dot(d, target - bias), 1 / weight);
    const Vec3 moment = cross(p - ws_.p0, d);
    for (const int i : chain) row[at(i)] = dot(ws_.S[at(i)].w, moment) + dot(ws_.S[at(i)].v, d);
  }
}

/// Orientation of a foot in the reference. A nearly level sole is made level, because measured soles are tilted by a few degrees in stance.
Mat3 BalanceControl::levelled(std::size_t f) const {
  const Mat3& R = ref_.X_WB[at(feet_[f].link)].R;
  const Vec3 normal = R * feet_[f].normal, axis = cross(normal, Vec3{0, 0, 1});
  const double tilt = atan2(norm(axis), normal.z);
  if (tilt < 1e-9 || tilt > options_.steep) return R;
  const double share = 1 - smooth_step((tilt - options_.flat) / (options_.steep - options_.flat)).value;
  return rotation_about(normalized(axis), tilt * share) * R;
}

void BalanceControl::add_turn_task(int link, const Mat3& R_ref, double frequency, double weight) {
  const auto l = at(link);
  const Pose &X = ws_.X_WB[l], &X_ref = ref_.X_WB[l];
  const Vec3 error = log_map(to_quat(R_ref * X.R.transposed()));
  const std::span<const int> chain = dynamics::chain_of_link(ws_, link);
  Vec3 alpha = dynamics::calc_jacobian_bias(*mechanism_, ref_, link, dynamics::JacobianFrame::world, X_ref.p).w;
  for (const int i : dynamics::chain_of_link(ref_, link)) alpha += ref_.S[at(i)].w * a_ref_[at(i)];
  const Vec3 bias = dynamics::calc_jacobian_bias(*mechanism_, ws_, link, dynamics::JacobianFrame::world, X.p).w;
  const Vec3 target = alpha + error * (frequency * frequency) + (ref_.V[l].w - ws_.V[l].w) * (2 * frequency) - bias;
  for (int k = 0; k < 3; ++k) {
    const std::span<double> row = program_.add_equation(target[k], 1 / weight);
    for (const int i : chain) row[at(i)] = ws_.S[at(i)].w[k];
  }
}

void BalanceControl::add_swing_task(std::size_t f, const BalanceState& state) {
  const Foot& foot = feet_[f];
  const BalanceState::FootState& memory = state.feet[f];
  const auto l = at(foot.link);
  const ScheduledFoot planned = schedule_.at(f, state.time);
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
  const Vec3 p = ws_.X_WB[l] * foot.sole, p_ref = ref_.X_WB[l] * foot.sole;
  Vec3 a = dynamics::calc_jacobian_bias(*mechanism_, ref_, foot.link, dynamics::JacobianFrame::world, p_ref).v;
  for (const int i : dynamics::chain_of_link(ref_, foot.link))
    a += (ref_.S[at(i)].v + cross(ref_.S[at(i)].w, p_ref - ref_.p0)) * a_ref_[at(i)];
  const Vec3 offset{memory.offset[0], memory.offset[1], memory.offset[2]}, shift{memory.shift[0], memory.shift[1], 0};
  const double up = 4 * phase * (1 - phase), down = std::clamp((phase - 0.7) / 0.3, 0.0, 1.0);
  Vec3 goal = p_ref + offset * (1 - s.value) + shift * s.value +
              Vec3{0, 0, (memory.reacts ? options_.step_clearance : options_.clearance) * up - options_.aim_depth * down};
  Vec3 speed = dynamics::point_velocity(ref_, foot.link, p_ref) + (shift - offset) * s.rate;
  a += (shift - offset) * s.acceleration;
  const double w = options_.swing_frequency;
  const Vec3 v = dynamics::point_velocity(ws_, foot.link, p);
  Vec3 target = a + (goal - p) * (w * w) + (speed - v) * (2 * w);
  if (late) target.z = options_.sole_damping * (-options_.press_speed - v.z);
  const Vec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  add_point_rows(foot.link, p, target, options_.swing_weight, axes);
  add_turn_task(foot.link, levelled(f), w, options_.swing_turn_weight);
}

void BalanceControl::add_standing_foot(std::size_t f) {
  // Rows for each link that bears load: three at the first point, two at the second, one at a third point that is not on their line.
  for (const int link : feet_[f].parts) {
    const Bearing *first = nullptr, *second = nullptr, *third = nullptr;
    double best = 1e-3;
    for (const Bearing& b : bearing_)
      if (b.link == link && !first) first = &b;
    if (!first) continue;
    for (const Bearing& b : bearing_)
      if (b.link == link && norm(b.p - first->p) > best) second = &b, best = norm(b.p - first->p);
    best = 1e-3;
    if (second) {
      const Vec3 along = normalized(second->p - first->p);
      for (const Bearing& b : bearing_)
        if (b.link == link && norm(cross(along, b.p - first->p)) > best) third = &b, best = norm(cross(along, b.p - first->p));
    }
    const auto slow = [&](const Vec3& p) { return dynamics::point_velocity(ws_, link, p) * -options_.sole_damping; };
    const Vec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    add_point_rows(link, first->p, slow(first->p), options_.sole_weight, axes);
    if (!second) continue;
    const Vec3 along = normalized(second->p - first->p), side = normalized(cross(first->n, along)), up = cross(along, side);
    const Vec3 across[2] = {side, up};
    add_point_rows(link, second->p, slow(second->p), options_.sole_weight, across);
    if (!third) continue;
    const Vec3 out[1] = {normalized(cross(along, third->p - first->p))};
    add_point_rows(link, third->p, slow(third->p), options_.sole_weight, out);
  }
}

template <class Edge>
void BalanceControl::find_torques(const BalanceInput& in, const Edge& edge, std::span<double> tau) {
  const Mechanism& m = *mechanism_;
  std::ranges::copy(program_.x(), wanted_.begin());
  dynamics::calc_inverse_dynamics(m, ws_, wanted_, options_.gravity, {}, tau);
  for (std::size_t b = 0; b < bearing_.size(); ++b) {
    Vec3 force;
    for (std::size_t k = 4 * b; k < 4 * b + 4; ++k) force += edge(k) * program_.loads()[k];
    const Vec3 moment = cross(bearing_[b].p - ws_.p0, force);
    for (const int i : dynamics::chain_of_link(ws_, bearing_[b].link))
      tau[at(i)] -= dot(ws_.S[at(i)].w, moment) + dot(ws_.S[at(i)].v, force);
  }
  for (std::size_t i = 6; i < wanted_.size(); ++i) {  // compensate the joints' dampers and springs, which the stepper applies
    const Dof& d = ws_.dofs[i];
    const double next = in.v[i] + in.dt * wanted_[i];
    tau[i] += d.damping * next;
    if (d.stiffness > 0) tau[i] += d.stiffness * (displacement_[i] + in.dt * next - d.rest);
  }
}

BalanceOutput BalanceControl::step(const BalanceInput& in, BalanceState& state, std::span<double> tau) {
  const Mechanism& m = *mechanism_;
  const std::size_t n = at(m.nv());
  UGOKI_CHECK(tau.size() == n && in.q.size() == at(m.nq()) && in.v.size() == n);
  BalanceOutput out;
  // 1., 2. Phase and anchor
  dynamics::update_kinematics(m, in.q, in.v, ws_);
  sample_reference(state);
  update_phase(in, state);
  update_anchor(in, state);
  sample_reference(state);
  find_bearing(in, state);
  now_ = dynamics::calc_centroidal(m, ws_);

  // 3. Centre of mass
  const double g = norm(options_.gravity);
  const double w0 = std::sqrt(g / std::max(0.05, want_.centre.z - floor_));
  // The reference moves from one foot to the other at the velocity u for the remaining time T. A DCM that is ahead of the reference by u /
  // w0 (1 - exp(-w0 T)) arrives without effort.
  const Vec3 e = now_.centre - want_.centre;
  const Vec3 e_rate = now_.velocity - want_.velocity - anchor_rate_ * (1 - exp(-w0 * anchor_rest_));
  out.dcm_error = horizontal(e + e_rate / w0);
  update_reactions(in, state, w0);
  Vec3 acceleration = want_rate_.v / m.mass() - e * (w0 * options_.com_gain) - e_rate * (w0 + options_.com_gain);
  acceleration.z =
      want_rate_.v.z / m.mass() - e.z * options_.height_frequency * options_.height_frequency - e_rate.z * 2 * options_.height_frequency;

  // 4. Shift of the next steps
  for (std::size_t f = 0; f < feet_.size(); ++f) {
    BalanceState::FootState& foot = state.feet[f];
    const ScheduledFoot planned = schedule_.at(f, state.time);
    if (foot.stands || (!foot.reacts && (planned.stands || !std::isfinite(planned.end)))) continue;
    const double rest = foot.reacts ? std::max(0.0, foot.begin + foot.length - state.clock) : (planned.end - state.time) / state.rate;
    double double_support = 0;  // s, duration of the double support after this touch-down
    for (std::size_t other = 0; other < feet_.size(); ++other) {
      if (other == f) continue;
      const ScheduledFoot next = schedule_.at(other, planned.end);
      if (next.stands && std::isfinite(next.end)) double_support = std::max(double_support, next.end - planned.end);
    }
    if (foot.reacts) {  // DCM of an inverted pendulum on p, the point of the support closest to the DCM
      const Vec3 dcm = horizontal(now_.centre + now_.velocity / w0);
      Vec3 p;
      if (distance_to_support(-1, in, state, dcm, p) < -1e2) continue;  // no foot stands
      Vec3 shift = out.dcm_error + (dcm - p) * (exp(w0 * rest) - 1);
      if (norm(shift) > options_.max_shift) shift = shift * (options_.max_shift / norm(shift));
      const Vec3 left = normalized(horizontal(ws_.X_WB[0].R * transpose_times(rest_pelvis_, Vec3{0, 1, 0})), {0, 1, 0});
      const Vec3 other = horizontal(ws_.X_WB[at(feet_[1 - f].link)] * feet_[1 - f].sole);
      const double side = f == left_foot_ ? 1 : -1;
      const double apart = side * dot(horizontal(ref_.X_WB[at(feet_[f].link)] * feet_[f].sole) + shift - other, left);
      if (apart < options_.separation) shift += left * (side * (options_.separation - apart));
      for (int k = 0; k < 2; ++k) foot.shift[k] += (shift[k] - foot.shift[k]) * std::min(1.0, in.dt / options_.shift_time);
      continue;
    }
    Vec3 shift =
        out.dcm_error * (exp(options_.shift_growth * rest) * transfer_factor(w0 * std::min(double_support, options_.max_transfer)));
    if (norm(shift) > options_.max_shift) shift = shift * (options_.max_shift / norm(shift));
    for (int k = 0; k < 2; ++k) foot.shift[k] += (shift[k] - foot.shift[k]) * std::min(1.0, in.dt / options_.shift_time);
  }

  // 5. Quadratic program
  program_.begin(m.nv(), 4 * static_cast<int>(bearing_.size()), options_.load_cost);
  difference(m, in.q, q_ref_, error_);
  const std::span<double> weights = program_.weights(), centre = program_.centre();
  const double kp = options_.joint_frequency * options_.joint_frequency, kd = 2 * options_.joint_frequency;
  for (std::size_t i = 0; i < n; ++i) {
    weights[i] = i < 6 ? 1e-3 : is_leg_[i] ? options_.leg_weight : options_.joint_weight;
    const double slip = v_ref_[i] - in.v[i];
    centre[i] = a_ref_[i] + (kp * (error_[i] + in.dt * slip) + kd * slip) / (1 + in.dt * kd + in.dt * in.dt * kp);
  }
  dynamics::calc_centroidal_matrix(m, ws_, A_G_);
  const Vec6 rate_bias = dynamics::calc_centroidal_momentum_rate(m, ws_, {});
  for (int k = 0; k < 3; ++k) {
    const std::span<double> row = program_.add_equation(acceleration[k] - rate_bias.v[k] / m.mass(), 1 / options_.com_weight);
    for (std::size_t i = 0; i < n; ++i) row[i] = A_G_[i].v[k] / m.mass();
  }
  const double inertia = (now_.inertia.xx + now_.inertia.yy + now_.inertia.zz) / 3;
  for (int k = 0; k < 3; ++k) {
    const double target = want_rate_.w[k] - options_.momentum_gain * (now_.momentum.w[k] - want_.momentum.w[k]) - rate_bias.w[k];
    const std::span<double> row = program_.add_equation(target / inertia, 1 / options_.momentum_weight);
    for (std::size_t i = 0; i < n; ++i) row[i] = A_G_[i].w[k] / inertia;
  }
  add_turn_task(0, ref_.X_WB[0].R, options_.trunk_frequency, options_.pelvis_weight);
  if (chest_ >= 0) add_turn_task(chest_, ref_.X_WB[at(chest_)].R, options_.trunk_frequency, options_.chest_weight);
  for (std::size_t f = 0; f < feet_.size(); ++f) {
    if (state.feet[f].stands)
      add_standing_foot(f);
    else
      add_swing_task(f, state);
  }
  dynamics::calc_inverse_dynamics(m, ws_, {}, options_.gravity, {}, bias_);
  dynamics::calc_inertia_rows(m, ws_);
  const auto edge = [&](std::size_t k) {
    const Bearing& b = bearing_[k / 4];
    const Vec3 t1 = any_perpendicular(b.n), t = k % 4 < 2 ? t1 : cross(b.n, t1);
    return b.n + t * ((k % 2 ? -1 : 1) * options_.friction_margin * b.friction);
  };
  for (std::size_t r = 0; r < 6; ++r) {
    const QuadraticProgram::Balance row = program_.add_balance(-bias_[r], -bias_[r], 0);
    for (std::size_t i = 0; i < n; ++i) {
      if (i >= 6)
        row.c[i] = ws_.M[at(ws_.row_start[i]) + r];
      else
        row.c[i] = i >= r ? ws_.M[at(ws_.row_start[i]) + r] : ws_.M[at(ws_.row_start[r]) + i];
    }
    for (std::size_t k = 0; k < row.g.size(); ++k) {
      const Vec3 f = edge(k);
      row.g[k] = -(dot(ws_.S[r].w, cross(bearing_[k / 4].p - ws_.p0, f)) + dot(ws_.S[r].v, f));
    }
  }
  out.solved = program_.solve(state.multipliers);
  out.iterations = program_.iterations();
  for (std::size_t r = 0; r < 6; ++r) state.multipliers[r] = program_.balance_multipliers()[r];
  for (const Link& link : m.links()) joint_displacement(link.joint, in.q.data() + link.q_index, displacement_.data() + link.v_index);
  find_torques(in, edge, tau);
  // Add only those torque limits that the solution exceeds. They are few, so the other limits add no cost.
  limited_.clear();
  for (int round = 0; round < options_.limit_rounds; ++round) {
    const std::size_t known = limited_.size();
    for (std::size_t i = 6; i < n && limited_.size() < max_limits; ++i) {
      const Dof& d = ws_.dofs[i];
      if (std::fabs(tau[i]) <= d.effort * (1 + 1e-6) || std::ranges::any_of(limited_, [&](int k) { return k == static_cast<int>(i); }))
        continue;
      limited_.push_back(static_cast<int>(i));
      const double passive = d.damping * in.v[i] + (d.stiffness > 0 ? d.stiffness * (displacement_[i] + in.dt * in.v[i] - d.rest) : 0.0);
      const QuadraticProgram::Balance row = program_.add_balance(-d.effort - bias_[i] - passive, d.effort - bias_[i] - passive, 1e-4);
      for (std::size_t j = 0; j < n; ++j) {
        const std::size_t low = ws_.depth[i] <= ws_.depth[j] ? i : j, high = low == i ? j : i;
        const auto entry = at(ws_.row_start[high] + ws_.depth[low]);
        if (ws_.chain[entry] == static_cast<int>(low)) row.c[j] = ws_.M[entry];
      }
      row.c[i] += in.dt * d.damping + in.dt * in.dt * std::max(0.0, d.stiffness);
      for (std::size_t k = 0; k < row.g.size(); ++k) {
        const std::span<const int> chain = dynamics::chain_of_link(ws_, bearing_[k / 4].link);
        if (std::ranges::none_of(chain, [&](int c) { return c == static_cast<int>(i); })) continue;
        const Vec3 f = edge(k);
        row.g[k] = -(dot(ws_.S[i].w, cross(bearing_[k / 4].p - ws_.p0, f)) + dot(ws_.S[i].v, f));
      }
    }
    if (limited_.size() == known) break;
    out.solved = program_.solve();
    out.iterations += program_.iterations();
    find_torques(in, edge, tau);
  }
  out.limits = static_cast<int>(limited_.size());
  out.residual = program_.residual();
  for (std::size_t i = 0; i < 6; ++i) tau[i] = 0;
  for (std::size_t i = 6; i < n; ++i) {
    const Dof& d = ws_.dofs[i];
    tau[i] = std::clamp(tau[i], -d.effort, d.effort);
  }
  state.time += state.rate * in.dt;
  state.clock += in.dt;
  return out;
}

}  // namespace ugoki::control
