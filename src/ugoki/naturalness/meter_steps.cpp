// Stances, swings and steps of the Meter.

#include <algorithm>
#include <cmath>

#include "ugoki/dynamics/dynamics.h"
#include "ugoki/naturalness/meter.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::naturalness {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

double lowest(const Leg& leg, std::span<const Pose> X) {
  double low = 1e300;
  for (const LinkPoint& p : leg.limb.points) low = std::min(low, (X[at(p.link)] * p.location.p).z - p.location.radius);
  return low;
}

/// Angle [deg] between thigh and shank; 0: the leg is straight.
double knee_angle(const Leg& leg, std::span<const Pose> X) {
  const Vec3 knee = X[at(leg.knee)].p, thigh = knee - X[at(leg.hip)].p, shank = X[at(leg.limb.link)].p - knee;
  return atan2(norm(cross(thigh, shank)), dot(thigh, shank)) * 180 / pi;
}

constexpr double rest_speed = 0.1;   // m/s: a standing foot moves up or down more slowly than this
constexpr double stand_speed = 0.4;  // m/s: a foot that is faster does not stand, even if a contact was detected
constexpr double rest_time = 0.05;   // s: a foot that turns round in the air is slow for a shorter time
// s: standard deviation of the Gaussian with the half-power frequency of 6 Hz, the low-pass of recordings: sqrt(ln 2) / (2 pi 6 Hz)
constexpr double force_sigma = 0.0221;
constexpr double min_stance = 0.15;  // s: the ground force of shorter stances has no shape

}  // namespace

void Meter::add_legs(const Sample& s) {
  for (std::size_t k = 0; k < leg_states_.size(); ++k) {
    LegState& leg = leg_states_[k];
    const bool on = k < s.touches.size() && s.touches[k] != 0;
    if (sums_.samples == 0) {
      leg.on = on ? 1 : 0;
      leg.place = s.X_WB[at(body_.legs[k].limb.link)].p;
    } else if (on != (leg.on > 0)) {
      if (on)
        touch_down(k, s);
      else
        lift_off(k);
      leg.on = on ? 1 : 0;
      leg.since = 0;
      leg.complete = gait() ? 1 : 0;
      leg.series.clear();
      leg.peak = 0;
    }
    leg.since += s.dt;
    const double height = lowest(body_.legs[k], s.X_WB) - options_.ground;
    if (on) {
      if (k < s.forces.size()) leg.series.add(s.forces[k].z);
      if (s.dt > 0 && std::fabs(height - leg.last_height) < rest_speed * s.dt) {
        leg.height_sum += height;
        leg.height_count += 1;
      }
    } else {
      leg.series.add(height);
    }
    leg.last_height = height;
  }
}

void Meter::touch_down(std::size_t k, const Sample& s) {
  LegState& leg = leg_states_[k];
  const Leg& shape = body_.legs[k];
  const Vec3 place = s.X_WB[at(shape.limb.link)].p;
  if (gait()) {
    // The middle of the swing: the foot is lowest there while it is fast (minimum toe clearance).
    if (leg.complete > 0 && walks() && leg.series.size() >= 8) {
      const int n = leg.series.size();
      double low = 1e300;
      for (int i = static_cast<int>(0.35 * n); i < static_cast<int>(0.75 * n); ++i) low = std::min(low, leg.series.values[i]);
      set(MeasureId::clearance, std::max(0.0, 1000 * (low - leg.stand_height)));
    }
    if (body_.biped() && walks() && shape.knee >= 0) set(MeasureId::knee, knee_angle(shape, s.X_WB));
    if (shape.other >= 0) {
      const LegState& other = leg_states_[at(shape.other)];
      const double time = sums_.time - other.touched_at, speed = std::sqrt(sums_.speed_x * sums_.speed_x + sums_.speed_y * sums_.speed_y);
      const Vec3 way = place - other.place;
      // A step that takes longer than two steps at the slowest gait is a pause.
      if (other.touched_at >= 0 && time < 2 * body_.centre_height / (0.15 * unit_speed_)) {
        leg.step_time = time;
        leg.step_length = (way.x * sums_.speed_x + way.y * sums_.speed_y) / std::max(1e-9, speed);
        leg.step_times += time;
        leg.step_lengths += leg.step_length;
        leg.steps += 1;
      }
    }
    if (leg.touched_at >= 0 && leg.torque_time > 0.1 && sums_.had_torque > 0) {
      leg.torque = std::sqrt(leg.torque_sum / leg.torque_time);
      leg.torques += leg.torque;
      leg.strides += 1;
    }
    compare_sides(k);
    leg.touched_at = sums_.time;
  } else {
    leg.touched_at = -1;
  }
  leg.torque_sum = leg.torque_time = 0;
  leg.place = place;
  leg.height_sum = leg.height_count = 0;
}

void Meter::lift_off(std::size_t k) {
  LegState& leg = leg_states_[k];
  if (leg.height_count > 0) leg.stand_height = leg.height_sum / leg.height_count;
  if (leg.complete == 0 || !gait()) return;
  leg.stance_time = leg.since;
  leg.stance_times += leg.since;
  leg.stances += 1;
  compare_sides(k);
  if (leg.since < min_stance || sums_.had_forces == 0) return;
  // The forces of recordings come from motions that were filtered; those of a simulation are compared with the same limits.
  if (options_.simulated && leg.series.size() > 0) smooth(leg.series, leg.since / leg.series.size(), force_sigma);
  if (const ForceShape shape = fit_force(leg.series); shape.valid) {
    set(MeasureId::force_shape, 100 * shape.residual);
    if (walks() && body_.biped()) set(MeasureId::force_humps, std::max(0.0, shape.humps));
  }
  if (walks() && body_.biped())
    set(MeasureId::step_force, *std::max_element(leg.series.values, leg.series.values + leg.series.size()) / weight_);
}

/// Compares the last step, stance and stride of a leg with those of the other side.
void Meter::compare_sides(std::size_t k) {
  if (body_.legs[k].other < 0) return;
  const LegState &a = leg_states_[k], &b = leg_states_[at(body_.legs[k].other)];
  const auto differ = [](double x, double y) {
    if (x == no_value || y == no_value || std::fabs(x) + std::fabs(y) == 0) return no_value;
    return 200 * std::fabs(x - y) / (std::fabs(x) + std::fabs(y));
  };
  now_[index_of(MeasureId::step_symmetry)] = std::max(differ(a.step_time, b.step_time), differ(a.step_length, b.step_length));
  now_[index_of(MeasureId::stance_symmetry)] = differ(a.stance_time, b.stance_time);
  now_[index_of(MeasureId::torque_symmetry)] = differ(a.torque, b.torque);
}

/// Height of standing feet above the ground, while they move neither up nor down.
void Meter::add_hover(const Sample& s) {
  double worst = no_value;
  for (std::size_t k = 0; k < leg_states_.size(); ++k) {
    LegState& leg = leg_states_[k];
    leg.rest += s.dt;
    if (k >= s.stands.size() || !s.stands[k]) leg.rest = 0;
    const double height = lowest(body_.legs[k], s.X_WB) - options_.ground;
    const int link = body_.legs[k].limb.link;
    const Vec3 speed = dynamics::point_velocity(ws_, link, ws_.X_WB[at(link)].p);
    if (std::fabs(speed.z) > rest_speed || norm(speed) > stand_speed) leg.rest = 0;
    if (leg.rest < rest_time) continue;
    worst = std::max(worst, 1000 * std::max(0.0, height));
  }
  now_[index_of(MeasureId::hover)] = worst;
  if (worst >= 0) set(MeasureId::hover, worst, s.dt);
}

}  // namespace ugoki::naturalness
