#include "ugoki/naturalness/meter.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "ugoki/base/check.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::naturalness {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }
double level(const Vec3& x) { return std::sqrt(x.x * x.x + x.y * x.y); }

/// Froude-scaled speed above which a character travels: 0.46 m/s for a human.
constexpr double gait_speed = 0.15;
/// s: shorter times without contact are gaps in the detection of contacts.
constexpr double min_air = 0.05;
/// s: a walk has had no flight for this time.
constexpr double walk_time = 0.6;
/// s: a parabola is fitted to flights of at least this duration, because the error of its gravity grows with 1 / duration^2.
constexpr double min_fit = 0.1;

/// Bounds of the rms jerk of recorded motions, in units of g sqrt(g / h): links from the root to the head in a walk and otherwise, legs,
/// and other links. Calibration: docs/naturalness.md.
constexpr double walk_jerk = 4.2, trunk_jerk = 7.5, leg_jerk = 20, arm_jerk = 25;
/// Jerk in units of g sqrt(g / h) that is added to both sides of the jerk ratio, so that links at rest have a ratio of 1.
constexpr double jerk_floor = 0.3;

}  // namespace

Meter::Meter(const Mechanism& m, const MeterOptions& options)
    : m_(m), options_(options), body_(find_legs(m)), slip_(m, body_.feet), penetration_(m, options.ground), ws_(m) {
  weight_ = m.mass() * options.gravity;
  const double g = std::max(1e-3, options.gravity);
  unit_speed_ = std::sqrt(g * body_.centre_height);
  unit_jerk_ = g * std::sqrt(g / body_.centre_height);
  for (int i = body_.floating ? 6 : 0; i < m.nv(); ++i) limited_torque_ = limited_torque_ || std::isfinite(m.dof(i).effort);
  leg_states_.resize(body_.legs.size());
  smooth_.resize(at(m.link_count()));
  reset();
}

void Meter::reset() {
  sums_ = {};
  sums_.ground_time = walk_time;
  now_.fill(no_value);
  sum_.fill(0);
  count_.fill(0);
  std::ranges::fill(leg_states_, LegState{});
  std::ranges::fill(smooth_, Smooth{});
  slip_.reset();
  penetration_.reset();
}

void Meter::set(MeasureId id, double value, double weight) {
  const std::size_t i = index_of(id);
  now_[i] = value;
  if (weight <= 0) return;
  switch (info_of(id).total) {
    case Total::rms: sum_[i] += weight * value * value; break;
    case Total::maximum: sum_[i] = std::max(sum_[i], value); break;
    default: sum_[i] += weight * value;
  }
  count_[i] += weight;
}

bool Meter::gait() const {
  return std::sqrt(sums_.speed_x * sums_.speed_x + sums_.speed_y * sums_.speed_y) > gait_speed * unit_speed_ &&
         centroidal_.centre.z - options_.ground > 0.7 * body_.centre_height;
}
bool Meter::walks() const { return gait() && sums_.ground_time >= walk_time; }

void Meter::add(const Sample& s) {
  const double dt = sums_.samples > 0 ? s.dt : 0;
  slip_.add(s.X_WB, s.stance, dt);
  const double depth = penetration_.add(s.X_WB);
  dynamics::update_kinematics(m_, s.q, s.v, s.known, ws_);
  centroidal_ = dynamics::calc_centroidal(m_, ws_);
  const Vec3 c = centroidal_.centre, u = centroidal_.velocity;
  if (sums_.samples == 0) {
    sums_.speed_x = u.x;
    sums_.speed_y = u.y;
    sums_.centre = c;
  }
  sums_.time += dt;
  const double mix = 1 - exp(-dt / 0.4);
  sums_.speed_x += mix * (u.x - sums_.speed_x);
  sums_.speed_y += mix * (u.y - sums_.speed_y);
  sums_.distance += level(c - sums_.centre);
  sums_.centre = c;

  if (!body_.feet.empty()) {
    now_[index_of(MeasureId::slip)] = slip_.now_cm();
    if (std::ranges::any_of(s.stance, [](std::uint8_t on) { return on != 0; })) count_[index_of(MeasureId::slip)] += 1;
  }
  set(MeasureId::penetration, 1000 * depth);
  Sample timed = s;
  timed.dt = dt;
  if (body_.floating) {
    add_flight(timed);
    add_forces(timed);
    add_legs(timed);
    add_hover(timed);
    if (body_.biped() && walks()) {
      const double speed = std::max(gait_speed * unit_speed_, level(u)), height = std::max(0.01, c.z - options_.ground);
      set(MeasureId::angular_momentum, norm(centroidal_.momentum.w) / (centroidal_.mass * speed * height), dt);
    } else {
      now_[index_of(MeasureId::angular_momentum)] = no_value;
    }
  }
  add_jerk(timed);
  add_torque(timed);
  if (walks()) sums_.walked += dt;
  if (gait() && !walks()) sums_.ran += dt;
  sums_.samples += 1;
}

void Meter::add_flight(const Sample& s) {
  const bool air = !body_.legs.empty() && !s.other_contact && std::ranges::none_of(s.touches, [](std::uint8_t on) { return on != 0; });
  if (!air) {
    if (sums_.air_time >= min_air) {
      sums_.ground_time = 0;
      end_flight();
    }
    sums_.air_time = 0;
    sums_.ground_time += s.dt;
    sums_.flight = {};
    return;
  }
  sums_.air_time += s.dt;
  if (sums_.samples == 0) sums_.flight.held = -1e9;  // the begin of this flight was not seen
  // The first and the last two samples of a flight are left out: labels of contacts are not more accurate.
  Flight& f = sums_.flight;
  if (f.held < 2) {
    f.held += 1;
    return;
  }
  if (f.held >= 4) {
    const double t = f.pending_t[0];
    const Vec3 p = f.pending[0];
    if (f.n == 0) f.origin = p;
    double power = 1;
    for (int k = 0; k < 5; ++k) {
      f.s[k] += power;
      if (k < 3) f.y[k] += (p - f.origin) * power;
      power *= t;
    }
    f.n += 1;
    f.t = t;
  }
  f.pending[0] = f.pending[1];
  f.pending_t[0] = f.pending_t[1];
  f.pending[1] = centroidal_.centre;
  f.pending_t[1] = sums_.air_time;
  f.held += 1;
}

/// Fits c(t) = a + b t + d t^2 / 2 to the flight.
void Meter::end_flight() {
  const Flight& f = sums_.flight;
  if (f.n < 5 || sums_.air_time < min_fit) return;
  const double* s = f.s;
  const Mat3 normal{s[0], s[1], s[2], s[1], s[2], s[3], s[2], s[3], s[4]};
  const Mat3 inverted = inverse(normal);
  Vec3 velocity, acceleration;
  for (int k = 0; k < 3; ++k) {
    const Vec3 x = inverted * Vec3{f.y[0][k], f.y[1][k], f.y[2][k]};
    velocity[k] = x.y + x.z * f.t;  // in the middle of the flight, about t / 2
    acceleration[k] = 2 * x.z;
  }
  if (!is_finite(acceleration)) return;
  sums_.had_flight = 1;
  set(MeasureId::flight_gravity, 100 * std::fabs(-acceleration.z / options_.gravity - 1));
  if (level(velocity) > gait_speed * unit_speed_)
    set(MeasureId::flight_speed, 100 * level(acceleration) * f.t / level(velocity));
  else
    now_[index_of(MeasureId::flight_speed)] = no_value;
}

void Meter::add_forces(const Sample& s) {
  if (!s.forces.empty()) {
    double load = 0;
    for (const Vec3& force : s.forces) load += force.z;
    sums_.load += (sums_.samples > 0 ? 1 - exp(-s.dt / 0.01) : 1) * (load - sums_.load);
    sums_.peak = std::max(sums_.peak, sums_.load);
    set(MeasureId::ground_force, sums_.load / weight_, s.dt);
    sums_.had_forces = 1;
  }
  if (!s.has_missing || weight_ <= 0) return;
  // Hicks et al. (2015) compare with the peak ground force; before a peak was seen, with the weight.
  const double scale = std::max(weight_, sums_.peak);
  set(MeasureId::root_force, 100 * norm(s.missing_force) / scale, s.dt);
  set(MeasureId::root_moment, 100 * norm(s.missing_moment) / (scale * body_.centre_height), s.dt);
}

void Meter::filter(Stages& stages, const Vec3& input, double a, double b) {
  Vec3 before = stages.input, after = input;
  stages.input = input;
  for (Vec3& y : stages.y) {
    const Vec3 old = y;
    y = old * a + before * (b - a) + after * (1 - b);
    before = old;
    after = y;
  }
}

void Meter::add_jerk(const Sample& s) {
  const double w = 23 * unit_jerk_ / options_.gravity;
  // Each stage y' = w (u - y) of the filter is solved exactly for an input that is linear in the sample; w [rad/s]: 12 Hz for a human.
  const double x = w * s.dt, a = exp(-x), b = x > 0 ? (1 - a) / x : 0;
  const bool settled = sums_.time * w > 16;  // the filter has forgotten that it began at rest
  const double mix = 1 - exp(-s.dt / 0.15);
  double worst = 0, worst_ratio = 0;
  now_[index_of(MeasureId::head_acceleration)] = no_value;
  const auto third = [&](const Stages& f) {
    const Vec3 j = (f.y[0] - f.y[1] * 3 + f.y[2] * 3 - f.y[3]) * (w * w * w / unit_jerk_);
    return dot(j, j);
  };
  for (std::size_t i = 0; i < smooth_.size(); ++i) {
    const Link& link = m_.link(static_cast<int>(i));
    if (link.inertia.mass <= 0) continue;
    Smooth& f = smooth_[i];
    const Vec3 p = s.X_WB[i] * link.inertia.centre();
    const Vec3 r = s.reference.empty() ? p : s.reference[i] * link.inertia.centre();
    if (sums_.samples == 0) {
      f.body = {p, {p, p, p, p}};
      f.reference = {r, {r, r, r, r}};
      continue;
    }
    if (x > 0) filter(f.body, p, a, b);
    if (x > 0 && !s.reference.empty()) filter(f.reference, r, a, b);
    if (!settled || s.dt <= 0) continue;
    const double square = third(f.body), wanted = third(f.reference);
    f.square += mix * (square - f.square);
    f.reference_square += mix * (wanted - f.reference_square);
    const double bound = body_.in_leg[i] ? leg_jerk : !body_.in_trunk[i] ? arm_jerk : walks() ? walk_jerk : trunk_jerk;
    f.sum += square;
    f.bounded_sum += square / (bound * bound);
    f.reference_sum += wanted;
    f.count += 1;
    worst = std::max(worst, std::sqrt(f.square) / bound);
    worst_ratio = std::max(worst_ratio, (std::sqrt(f.square) + jerk_floor) / (std::sqrt(f.reference_square) + jerk_floor));
    if (static_cast<int>(i) == body_.head && body_.biped() && walks()) {
      const Vec3 acceleration = (f.body.y[1] - f.body.y[2] * 2 + f.body.y[3]) * (w * w / options_.gravity);
      set(MeasureId::head_acceleration, norm(acceleration), s.dt);
    }
  }
  if (!settled) return;
  if (options_.simulated)
    now_[index_of(MeasureId::jerk_ratio)] = s.reference.empty() ? no_value : worst_ratio;
  else if (body_.biped())
    now_[index_of(MeasureId::jerk)] = worst;
}

void Meter::add_torque(const Sample& s) {
  if (s.torque.empty()) return;
  sums_.had_torque = 1;
  double power = 0, over = 0;
  for (int i = body_.floating ? 6 : 0; i < m_.nv(); ++i) {
    power += std::max(0.0, s.torque[at(i)] * s.v[at(i)]);
    if (const double effort = m_.dof(i).effort; std::isfinite(effort) && effort > 0)
      over = std::max(over, std::fabs(s.torque[at(i)]) / effort);
  }
  for (std::size_t k = 0; k < leg_states_.size(); ++k) {
    LegState& leg = leg_states_[k];
    for (const int i : body_.legs[k].dofs) leg.torque_sum += s.dt * s.torque[at(i)] * s.torque[at(i)];
    leg.torque_time += s.dt;
  }
  if (limited_torque_) {
    set(MeasureId::torque, 100 * (over > 1 ? 1 : 0), s.dt);
    now_[index_of(MeasureId::torque)] = 100 * over;
  }
  sums_.work += power * s.dt;
  sums_.power += (1 - exp(-s.dt / 0.5)) * (power - sums_.power);
  const double speed = std::sqrt(sums_.speed_x * sums_.speed_x + sums_.speed_y * sums_.speed_y);
  now_[index_of(MeasureId::work)] = gait() && sums_.time > 0.5 ? sums_.power / (weight_ * speed) : no_value;
}

double Meter::value(MeasureId id) const {
  const std::size_t i = index_of(id);
  switch (id) {
    case MeasureId::slip: return count_[i] > 0 ? slip_.mean_cm() : no_value;
    case MeasureId::penetration: return sums_.samples > 0 ? penetration_.worst_mm() : no_value;
    case MeasureId::jerk:
    case MeasureId::jerk_ratio: {
      if (now_[i] == no_value) return no_value;
      double worst = 0;
      for (std::size_t k = 0; k < smooth_.size(); ++k) {
        if (smooth_[k].count <= 0) continue;
        const double rms = std::sqrt(smooth_[k].sum / smooth_[k].count), wanted = std::sqrt(smooth_[k].reference_sum / smooth_[k].count);
        worst = std::max(worst, id == MeasureId::jerk ? std::sqrt(smooth_[k].bounded_sum / smooth_[k].count)
                                                      : (rms + jerk_floor) / (wanted + jerk_floor));
      }
      return worst;
    }
    case MeasureId::work:  // over at least one body height and mostly in a gait, because standing work has no distance
      return sums_.had_torque > 0 && sums_.distance > body_.centre_height && sums_.walked + sums_.ran > 0.5 * sums_.time
                 ? sums_.work / (weight_ * sums_.distance)
                 : no_value;
    case MeasureId::step_symmetry:
    case MeasureId::stance_symmetry:
    case MeasureId::torque_symmetry: {
      double worst = no_value;
      const auto differ = [&](double a, double na, double b, double nb) {
        if (na < 1 || nb < 1 || na + nb < 3) return;
        a /= na;
        b /= nb;
        if (std::fabs(a) + std::fabs(b) > 0) worst = std::max(worst, 200 * std::fabs(a - b) / (std::fabs(a) + std::fabs(b)));
      };
      for (std::size_t k = 0; k < body_.legs.size(); ++k) {
        const int other = body_.legs[k].other;
        if (other <= static_cast<int>(k)) continue;
        const LegState &a = leg_states_[k], &b = leg_states_[at(other)];
        if (id == MeasureId::step_symmetry) {
          differ(a.step_times, a.steps, b.step_times, b.steps);
          differ(a.step_lengths, a.steps, b.step_lengths, b.steps);
        } else if (id == MeasureId::stance_symmetry) {
          differ(a.stance_times, a.stances, b.stance_times, b.stances);
        } else {
          differ(a.torques, a.strides, b.torques, b.strides);
        }
      }
      return worst;
    }
    default: break;
  }
  if (count_[i] <= 0) return no_value;
  switch (info_of(id).total) {
    case Total::rms: return std::sqrt(sum_[i] / count_[i]);
    case Total::maximum: return sum_[i];
    default: return sum_[i] / count_[i];
  }
}

Reason Meter::reason(MeasureId id) const {
  using enum MeasureId;
  const bool legs = !body_.legs.empty();
  switch (id) {
    case tracking:
    case assist:
    case fall: return Reason::only_simulated;
    case jerk_ratio: return options_.simulated ? Reason::no_reference : Reason::only_simulated;
    case jerk: return options_.simulated ? Reason::only_recorded : body_.biped() ? Reason::too_short : Reason::no_biped;
    case slip:
    case hover: return legs || !body_.feet.empty() ? Reason::no_stance : Reason::no_feet;
    case root_force:
    case root_moment: return !body_.floating ? Reason::fixed_root : legs ? Reason::no_forces : Reason::no_feet;
    case ground_force: return legs ? Reason::no_forces : Reason::no_feet;
    case flight_gravity: return legs ? Reason::no_flight : Reason::no_feet;
    case flight_speed: return !legs ? Reason::no_feet : sums_.had_flight > 0 ? Reason::no_level_flight : Reason::no_flight;
    case torque: return limited_torque_ ? Reason::no_torques : Reason::no_torque_limits;
    case work: return sums_.had_torque == 0 ? Reason::no_torques : Reason::no_travel;
    default: break;
  }
  if (!legs) return Reason::no_feet;
  if (id == step_symmetry || id == stance_symmetry || id == torque_symmetry)
    return body_.legs[0].other < 0 ? Reason::no_sides : Reason::few_steps;
  if (id == force_shape) return Reason::no_gait;
  if (id == clearance) return Reason::no_walk;
  if (!body_.biped()) return Reason::no_biped;
  if (id == head_acceleration) return body_.head < 0 ? Reason::no_head : Reason::no_walk;
  if (id == knee && body_.legs[0].knee < 0) return Reason::no_knee;
  return Reason::no_walk;
}

double Meter::total(MeasureId id) const {
  const double x = value(id);
  return x < 0 ? value_of(reason(id)) : x;
}

std::array<double, measure_count> Meter::totals() const {
  std::array<double, measure_count> out{};
  for (std::size_t i = 0; i < measure_count; ++i) out[i] = total(static_cast<MeasureId>(i));
  return out;
}

std::size_t Meter::memory_size() const {
  constexpr std::size_t unit = sizeof(double);
  static_assert(sizeof(Sums) % unit == 0 && sizeof(LegState) % unit == 0 && sizeof(Smooth) % unit == 0);
  return sizeof(Sums) / unit + 3 * measure_count + leg_states_.size() * (sizeof(LegState) / unit) +
         smooth_.size() * (sizeof(Smooth) / unit) + slip_.memory_size() + penetration_.memory_size();
}

void Meter::save(std::span<double> out) const {
  UGOKI_CHECK(out.size() == memory_size());
  double* to = out.data();
  const auto put = [&](const void* from, std::size_t bytes) {
    if (bytes > 0) std::memcpy(to, from, bytes);
    to += bytes / sizeof(double);
  };
  put(&sums_, sizeof sums_);
  put(now_.data(), sizeof now_);
  put(sum_.data(), sizeof sum_);
  put(count_.data(), sizeof count_);
  put(leg_states_.data(), leg_states_.size() * sizeof(LegState));
  put(smooth_.data(), smooth_.size() * sizeof(Smooth));
  slip_.save({to, slip_.memory_size()});
  penetration_.save({to + slip_.memory_size(), penetration_.memory_size()});
}

void Meter::restore(std::span<const double> in) {
  UGOKI_CHECK(in.size() == memory_size());
  const double* from = in.data();
  const auto get = [&](void* to, std::size_t bytes) {
    if (bytes > 0) std::memcpy(to, from, bytes);
    from += bytes / sizeof(double);
  };
  get(&sums_, sizeof sums_);
  get(now_.data(), sizeof now_);
  get(sum_.data(), sizeof sum_);
  get(count_.data(), sizeof count_);
  get(leg_states_.data(), leg_states_.size() * sizeof(LegState));
  get(smooth_.data(), smooth_.size() * sizeof(Smooth));
  slip_.restore({from, slip_.memory_size()});
  penetration_.restore({from + slip_.memory_size(), penetration_.memory_size()});
}

}  // namespace ugoki::naturalness
