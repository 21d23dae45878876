#include "ugoki/control/foot_phase.h"

#include <algorithm>
#include <cmath>

namespace ugoki::control {

namespace {

/// True if the sole of a foot that touches is not much higher than at its landing: a toe that scuffs the ground carries no load.
bool is_low(const BalanceModel& model, const GroundSupport& support, std::size_t f, const ScheduledFoot& planned) {
  if (!planned.next) return true;
  const GroundSupport::Ground ground = support.ground_under(model, f);
  const double landing = (planned.next->foot * model.feet[f].sole).z - model.floor;
  return !ground.found || model.sole(f).z - ground.height < std::max(0.0, landing) + model.options.max_tiptoe;
}

/// True if the ground below the way of a swing foot deviates from a straight line between both places: steps and tiles, but no slopes.
bool is_rough(const BalanceModel& model, const BalanceState& state, const BalanceState::FootState& foot) {
  constexpr double straight = 0.01;  // m
  constexpr int samples = 7;
  const Vec3 from{foot.from[0], foot.from[1], 0}, way = Vec3{foot.to[0], foot.to[1], 0} - from;
  const double last = model.map_height(state, from + way) + state.loose;
  for (int k = 1; k <= samples; ++k) {
    const double share = static_cast<double>(k) / (samples + 1);
    const double height = model.map_height(state, from + way * share) + state.loose;
    if (std::fabs(height - foot.from[2] - (last - foot.from[2]) * share) > straight) return true;
  }
  return false;
}

/// m: height of the lowest point of a foot of the reference above the reference's ground.
double height_in_reference(const BalanceModel& model, std::size_t f, const BalanceState& state) {
  double low = 1e9;
  for (const LinkPoint& point : model.feet[f].points)
    low = std::min(low, (model.ref.X_WB[static_cast<std::size_t>(point.link)] * point.location.p).z - point.location.radius);
  return low - model.floor - state.z + state.lower;
}

}  // namespace

void update_phase(const BalanceModel& model, const GroundSupport& support, double dt, BalanceState& state) {
  state.rate = 1;
  const double g = norm(model.options.gravity);
  const double thrust = 1 + model.want_rate.v.z / (model.mass() * g);  // body weights: ground force that the reference needs
  // Before a flight, the feet stay on the ground until the reference needs no more ground force.
  const bool pushes_off = thrust > model.options.push_off && model.schedule.flight(state.time);
  for (std::size_t f = 0; f < model.feet.size(); ++f) {
    BalanceState::FootState& foot = state.feet[f];
    const ScheduledFoot planned = model.schedule.at(f, state.time);
    if (!state.started) {
      foot.stands = planned.stands && support.touching(f) > 0;
      if (!foot.stands) model.lift(f, state);
    }
    if (foot.stands) {
      foot.lost = support.touching(f) > 0 ? 0 : foot.lost + dt;
      if (planned.stands) foot.early = 0;
      const bool lifts = !planned.stands && !foot.early && !pushes_off;
      if (lifts || foot.lost > 0.02) model.lift(f, state);
    } else if (foot.reacts) {
      if (!planned.stands || state.clock > foot.begin + foot.length + 0.3)
        foot.reacts = 0;  // the step ends: the reference lifts the foot, or the foot is pressed down until it touches the ground
      if (support.touching(f) > 0 && state.clock > foot.begin + model.options.early * foot.length) {
        foot.stands = 1;
        foot.reacts = foot.early = 0;
        foot.lost = 0;
      }
    } else {
      if (!planned.stands && support.blocked(f) && is_rough(model, state, foot) &&
          height_in_reference(model, f, state) > model.options.scuff)
        foot.raise = std::min(model.options.max_raise, foot.raise + dt * model.options.raise_speed);
      const double swing = planned.stands ? 1 : (state.time - planned.begin) / (planned.end - planned.begin);
      if (support.touching(f) > 0 && swing > model.options.early && (planned.stands || is_low(model, support, f, planned))) {
        foot.stands = 1;
        foot.early = planned.stands ? 0 : 1;
        foot.lost = 0;
      }
    }
    if (foot.early) state.rate = model.options.early_rate;
    if (model.options.hurry > 0 && !foot.stands && !planned.stands && !foot.reacts && state.rate == 1) {
      const double shift = norm(Vec3{foot.shift[0], foot.shift[1], 0});
      state.rate = std::clamp(1 + model.options.hurry * (shift - model.options.hurry_from), 1.0, model.options.max_hurry);
    }
  }
  for (std::size_t f = 0; f < model.feet.size(); ++f)
    if (!state.feet[f].stands && !state.feet[f].reacts && model.schedule.at(f, state.time).stands) state.rate = model.options.late_rate;
  if (state.rate == 1) state.rate = state.pace;
  state.started = 1;
  if (const Flight* flight = model.flight(state)) {
    // The reference lands when the character lands: its time runs so that both flights end together.
    const double fall = model.centroid.centre.z - model.floor - state.z - flight->landing, v = model.centroid.velocity.z;
    const double rest = (v + std::sqrt(std::max(0.0, v * v + 2 * g * fall))) / g;
    state.rate = std::clamp((flight->end - state.time) / std::max(rest, dt), 0.5, 2.0);
  }
}

}  // namespace ugoki::control
