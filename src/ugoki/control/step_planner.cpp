#include "ugoki/control/step_planner.h"

#include <algorithm>
#include <cmath>

#include "ugoki/spatial/elementary.h"

namespace ugoki::control {
namespace {

/// Factor on the shift of a touch-down. It is above 1 because the anchor moves to the new foot only during the following double support.
/// With x = w0 * (duration of the double support) and the error E at touch-down, the error at the end of the double support is E e^x -
/// shift (e^x - 1) / x. This error is zero for shift = factor * E.
double transfer_factor(double x) { return x < 1e-3 ? 1 + 0.5 * x : x * exp(x) / (exp(x) - 1); }

/// Share of the DCM error by which a foot that lands at time t [s] after a flight is shifted.
double landing_share(const BalanceModel& model, double t) {
  constexpr double together = 0.15;  // s: feet that land within this time land together
  for (std::size_t f = 0; f < model.feet.size(); ++f)
    if (!model.schedule.at(f, t + together).stands) return model.options.landing;
  return model.options.jump_landing;
}

}  // namespace

void StepPlanner::start_reaction(const BalanceModel& model, GroundSupport& support, double dt, BalanceState& state) {
  bool all_stand = true;
  double next_lift = 1e300;
  for (std::size_t f = 0; f < model.feet.size(); ++f) {
    const ScheduledFoot planned = model.schedule.at(f, state.time);
    all_stand = all_stand && state.feet[f].stands && planned.stands;
    if (planned.stands) next_lift = std::min(next_lift, (planned.end - state.time) / state.rate);
  }
  if (!all_stand || model.feet.size() != 2 || next_lift < 0.2) {
    state.trouble = 0;
    return;
  }
  const Vec3 dcm = horizontal(model.centroid.centre + model.centroid.velocity / model.w0),
             wanted = horizontal(model.want.centre + model.want.velocity / model.w0);
  const Vec3 error = dcm - wanted;
  Vec3 edge;
  const double margin = support.distance_to_edge(-1, state, dcm, edge);
  state.trouble = margin < -model.options.step_margin * norm(horizontal(model.want.velocity)) && norm(error) > model.options.step_error
                      ? state.trouble + dt
                      : 0;
  const Vec3 left = model.left();
  const auto place = [&](std::size_t f) { return horizontal(model.sole(f)); };
  const auto offset = [&](std::size_t f) { return place(f) - horizontal(model.reference_sole(f)); };
  if (state.trouble <= model.options.step_delay) return;
  const double grow = exp(model.w0 * model.options.step_time);
  double min_cost = 1e300;
  std::size_t swing = 0;
  Vec3 chosen;
  for (std::size_t f = 0; f < 2; ++f) {
    const std::size_t other = 1 - f;
    Vec3 p;
    support.distance_to_edge(static_cast<int>(other), state, dcm, p);
    Vec3 shift = p + (dcm - p) * grow - wanted - offset(other);  // m, relative to the reference as displaced to the other, standing foot
    // The feet must not cross.
    const double side = f == model.left_foot ? 1 : -1;
    const Vec3 landing = horizontal(model.reference_sole(f)) + offset(other) + shift;
    const double apart = side * dot(landing - place(other), left);
    const double crossing = std::max(0.0, model.options.separation - apart);
    shift += left * (side * crossing);
    const double cost = norm(landing - place(f)) + 3 * crossing;
    if (cost < min_cost) {
      min_cost = cost;
      swing = f;
      chosen = shift;
    }
  }
  model.lift(swing, state);
  BalanceState::FootState& foot = state.feet[swing];
  foot.reacts = 1;
  foot.begin = state.clock;
  foot.length = model.options.step_time;
  if (norm(chosen) > model.options.max_shift) chosen = chosen * (model.options.max_shift / norm(chosen));
  foot.shift[0] = chosen.x;
  foot.shift[1] = chosen.y;
  state.trouble = 0;
}

Vec3 StepPlanner::update_shifts(const BalanceModel& model, GroundSupport& support, double dt, const Vec3& dcm_error, BalanceState& state) {
  Vec3 lean;
  for (std::size_t f = 0; f < model.feet.size(); ++f) {
    BalanceState::FootState& foot = state.feet[f];
    const ScheduledFoot planned = model.schedule.at(f, state.time);
    if (foot.stands || (!foot.reacts && (planned.stands || !std::isfinite(planned.end)))) continue;
    const double rest = foot.reacts ? std::max(0.0, foot.begin + foot.length - state.clock) : (planned.end - state.time) / state.rate;
    double double_support = 0;  // s, duration of the double support after this touch-down
    for (std::size_t other = 0; other < model.feet.size(); ++other) {
      if (other == f) continue;
      const ScheduledFoot next = model.schedule.at(other, planned.end);
      // Only feet that stand already carry load until they lift. In a trot, two feet land together.
      if (next.stands && next.begin <= state.time && std::isfinite(next.end))
        double_support = std::max(double_support, next.end - planned.end);
    }
    if (foot.reacts) {  // DCM of an inverted pendulum on p, the point of the support closest to the DCM
      const Vec3 dcm = horizontal(model.centroid.centre + model.centroid.velocity / model.w0);
      Vec3 p;
      if (support.distance_to_edge(-1, state, dcm, p) < -1e2) continue;  // no foot stands
      Vec3 shift = dcm_error + (dcm - p) * (exp(model.w0 * rest) - 1);
      if (norm(shift) > model.options.max_shift) shift = shift * (model.options.max_shift / norm(shift));
      const Vec3 left = model.left();
      const Vec3 other = horizontal(model.sole(1 - f));
      const double side = f == model.left_foot ? 1 : -1;
      const double apart = side * dot(horizontal(model.reference_sole(f)) + shift - other, left);
      if (apart < model.options.separation) shift += left * (side * (model.options.separation - apart));
      for (int k = 0; k < 2; ++k) foot.shift[k] += (shift[k] - foot.shift[k]) * std::min(1.0, dt / model.options.shift_time);
      continue;
    }
    const double growth =
        exp(model.options.shift_growth * rest) * transfer_factor(model.w0 * std::min(double_support, model.options.max_transfer));
    const bool flies = model.flight(state) != nullptr;
    Vec3 shift = flies ? dcm_error * landing_share(model, planned.end) + horizontal(model.centroid.velocity - model.want.velocity) * rest
                       : dcm_error * growth;
    if (!flies) lean += Vec3{foot.place[0], foot.place[1], 0} / growth;
    if (norm(shift) > model.options.max_shift) shift = shift * (model.options.max_shift / norm(shift));
    for (int k = 0; k < 2; ++k) foot.shift[k] += (shift[k] - foot.shift[k]) * std::min(1.0, dt / model.options.shift_time);
  }
  return lean;
}

}  // namespace ugoki::control
