#include "ugoki/control/ground_plan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "ugoki/mechanism/state.h"
#include "ugoki/motion/clip.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::control {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

constexpr double max_slope = 0.4;  // rise per length: a steeper foothold counts as an edge, and the foot lands level

/// Phase of a swing from 0 to 1. A foot that lands late, or never, has the phase 1.
double swing_phase(const BalanceModel& model, const BalanceState& state, std::size_t f) {
  const BalanceState::FootState& foot = state.feet[f];
  if (foot.reacts) return (state.clock - foot.begin) / foot.length;
  const ScheduledFoot planned = model.schedule.at(f, state.time);
  const double length = planned.end - planned.begin;
  return planned.stands || !std::isfinite(length) ? 1 : (state.time - planned.begin) / length;
}

}  // namespace

GroundPlan::GroundPlan(const BalanceModel& model) {
  std::vector<Pose> X(at(model.mechanism->link_count()));
  calc_poses(*model.mechanism, model.mechanism->neutral(), X);
  for (const Foot& foot : model.feet) {
    // The rectangle around the lowest support points of the foot's link, in the neutral position.
    const Pose& X_foot = X[at(foot.link)];
    const double sole = (X_foot * foot.sole).z;
    Vec3 low{1e9, 1e9, 0}, high{-1e9, -1e9, 0};
    for (const LinkPoint& point : foot.points) {
      if (point.link != foot.link) continue;
      const Vec3 p = X_foot * point.location.p;
      if (p.z - point.location.radius > sole + 0.02) continue;
      for (int k = 0; k < 2; ++k) {
        low[k] = std::min(low[k], p[k]);
        high[k] = std::max(high[k], p[k]);
      }
    }
    const Vec3 size = low.x <= high.x ? (high - low) * 0.5 : Vec3{};
    const Vec3 middle = low.x <= high.x ? (high + low) * 0.5 + Vec3{0, 0, sole} : X_foot * foot.sole;
    half_.push_back({transpose_times(X_foot.R, Vec3{size.x, 0, 0}), transpose_times(X_foot.R, Vec3{0, size.y, 0})});
    middle_.push_back(X_foot.inverse() * middle);
  }
}

void GroundPlan::update(const BalanceModel& model, const GroundSupport& support, double dt, BalanceState& state) {
  update_body(model, support, dt, state);
  for (std::size_t f = 0; f < model.feet.size(); ++f)
    if (!state.feet[f].stands) update_foot(model, f, dt, state);
  lower_body(model, dt, state);
}

void GroundPlan::lower_body(const BalanceModel& model, double dt, BalanceState& state) {
  // Where a foot is lower than in the reference, for example the rear foot on a slope, its leg would be too long.
  double lower = 0;
  for (std::size_t f = 0; f < model.feet.size(); ++f) {
    const Foot& leg = model.feet[f];
    if (leg.hip < 0) continue;
    const double length = model.options.leg_share * model.schedule.leg_length(f);
    Vec3 sole = model.sole(f), hip = model.ref.X_WB[at(leg.hip)].p + Vec3{0, 0, state.lower};
    double share = 1;
    if (!state.feet[f].stands) {
      // A foot that will land soon: only the height of its foothold counts, because body and foot are displaced together.
      const ScheduledFoot planned = model.schedule.at(f, state.time);
      const double landing = state.feet[f].to[2] - model.floor - state.z;  // m: height of the foothold above the mean ground
      share = smooth_step((swing_phase(model, state, f) - 0.4) / 0.5).value;
      if (state.feet[f].reacts || planned.stands) {
        // The reference already stands on a foot that lands late, and contains no reaction steps.
        sole = model.reference_sole(f) + Vec3{0, 0, landing + state.lower};
      } else if (planned.next) {
        const Pose displaced = to_pose({state.x, state.y, state.z, state.heading});
        hip = displaced * planned.next->hip;
        sole = displaced * (planned.next->foot * leg.sole);
        sole.z += landing;
      } else {
        continue;
      }
    }
    const double distance = norm(horizontal(hip - sole));
    lower = std::max(lower, share * (hip.z - sole.z - std::sqrt(std::max(0.0, length * length - distance * distance))));
  }
  const double rise = (std::min(lower, 0.5 * model.max_step(state)) - state.lower) * std::min(1.0, dt / model.options.lower_time);
  state.lower += rise;
  climb_ -= rise / dt;
}

void GroundPlan::update_body(const BalanceModel& model, const GroundSupport& support, double dt, BalanceState& state) {
  const Vec3 centre = model.centroid.centre;
  const double share = std::min(1.0, dt / model.options.ground_time);
  // Ground that is not in the map (loose objects) is known only under the standing feet.
  double loose = 0, count = 0;
  for (std::size_t f = 0; f < model.feet.size(); ++f) {
    if (!state.feet[f].stands) continue;
    const GroundSupport::Ground ground = support.ground_under(model, f);
    if (!ground.found) continue;
    count += 1;
    // A foot that stands at the begin has not planned its foothold.
    BalanceState::FootState& foot = state.feet[f];
    const bool first = state.clock == 0;
    foot.to[2] += (ground.height - foot.to[2]) * (first ? 1 : share);
    if (first)
      for (int k = 0; k < 2; ++k) foot.tilt[k] = -ground.normal[k] / ground.normal.z;
    if (ground.loose) loose += ground.height - model.map_height(state, model.sole(f));
  }
  if (count > 0) state.loose += (loose / count - state.loose) * share;
  // Plane through points on two circles around the centre of mass.
  const double predicted = state.z + model.ground_rise(state, centre), size = centre.z - model.floor - predicted;
  double mean = 0, tilt[2] = {0, 0}, squares = 0;
  constexpr int points = 8;
  const Vec3 ahead = model.heading(), left = cross(Vec3{0, 0, 1}, ahead);
  for (int k = 0; k < points; ++k) {
    const double angle = 2 * pi * k / points;
    for (const double radius : {0.2 * size, 0.4 * size}) {
      const Vec3 d = (ahead * cos(angle) + left * sin(angle)) * radius;
      // Beside a cliff the ground under the character counts alone.
      const double expected = state.z + model.ground_rise(state, centre + d);
      const double found = model.map_height(state, centre + d) - model.floor;
      const double height = found > expected - 0.99 * model.max_step(state) ? found + state.loose : expected;
      mean += height / (2 * points);
      tilt[0] += height * d.x;
      tilt[1] += height * d.y;
      squares += 0.5 * radius * radius;
    }
  }
  const double rise = (mean - predicted) * share;
  climb_ = rise / dt;
  state.z = predicted + rise;
  for (int k = 0; k < 2; ++k) state.tilt[k] += (tilt[k] / std::max(squares, 1e-6) - state.tilt[k]) * share;
  state.ground[0] = centre.x;
  state.ground[1] = centre.y;
}

GroundPlan::Patch GroundPlan::under_sole(const BalanceModel& model, const BalanceState& state, std::size_t f, const Vec3& place,
                                         const Mat3& R, double margin) const {
  const Vec3 sole = horizontal(R * half_[f][0]), ahead = sole + normalized(sole) * margin, left = horizontal(R * half_[f][1]);
  const double length = norm(ahead), width = norm(left);
  const Vec3 middle = horizontal(R * (middle_[f] - model.feet[f].sole));
  double z[5], mean = 0;
  std::array<Vec3, 5> p{ahead + left, ahead - left, -ahead + left, -ahead - left, Vec3{}};
  for (std::size_t k = 0; k < 5; ++k) {
    z[k] = model.map_height(state, place + middle + p[k]) + state.loose;
    mean += z[k] / 5;
  }
  // Slopes along the foot and across it
  const double along = length > 1e-3 ? (z[0] + z[1] - z[2] - z[3]) / (4 * length) : 0,
               across = width > 1e-3 ? (z[0] + z[2] - z[1] - z[3]) / (4 * width) : 0;
  Patch patch;
  const double highest = *std::max_element(z, z + 5), lowest = *std::min_element(z, z + 5);
  if (std::max(std::fabs(along), std::fabs(across)) > max_slope) {
    patch.height = highest;
    patch.unevenness = highest - lowest;
    return patch;
  }
  const Vec3 x = length > 1e-3 ? ahead / length : Vec3{}, y = width > 1e-3 ? left / width : Vec3{};
  for (int k = 0; k < 2; ++k) patch.tilt[k] = along * x[k] + across * y[k];
  double raise = -1e9;
  for (std::size_t k = 0; k < 5; ++k) {
    const double gap = z[k] - mean - patch.tilt[0] * p[k].x - patch.tilt[1] * p[k].y;
    patch.unevenness = std::max(patch.unevenness, std::fabs(gap));
    raise = std::max(raise, gap);
  }
  patch.height = mean + raise - patch.tilt[0] * middle.x - patch.tilt[1] * middle.y;
  return patch;
}

Vec3 GroundPlan::choose_move(const BalanceModel& model, const BalanceState& state, std::size_t f, const Vec3& wanted, const Mat3& R) const {
  constexpr double even = 2e-3, same_height = 0.01;  // m
  const BalanceOptions& o = model.options;
  const BalanceState::FootState& foot = state.feet[f];
  const Patch here = under_sole(model, state, f, wanted, R, o.foothold_margin);
  const double phase = swing_phase(model, state, f);
  const bool begins = phase < 0.05;  // FootState::to is still the place that the foot left
  if (here.unevenness < even && (begins || std::fabs(here.height - foot.to[2]) < same_height)) return {};
  // The closer the landing, the more the foothold stays where it is: a foot that is low cannot reach another height.
  const double late = o.hold * std::clamp((phase - o.hold_from) / (1 - o.hold_from), 0.0, 1.0);
  const Vec3 ahead = normalized(horizontal(R * half_[f][0]));
  const double longest = o.max_move * 2 * norm(half_[f][0]);
  const double planned = std::clamp(dot(Vec3{foot.to[0], foot.to[1], 0} - wanted, ahead), -longest, longest);
  double best = std::numeric_limits<double>::infinity(), chosen = 0;
  constexpr int side = 5;  // candidates on each side
  for (int k = -side; k <= side + 1; ++k) {
    const double step = k > side ? planned : k * longest / side;
    const Patch ground = under_sole(model, state, f, wanted + ahead * step, R, o.foothold_margin);
    const double change = begins ? std::fabs(step) : std::fabs(step - planned);
    const double cost =
        ground.unevenness + o.move_cost * (std::fabs(step) + (0.3 + late) * change) + late * std::fabs(ground.height - foot.to[2]);
    if (cost < best) best = cost, chosen = step;
  }
  return ahead * chosen;
}

void GroundPlan::update_foot(const BalanceModel& model, std::size_t f, double dt, BalanceState& state) const {
  const BalanceOptions& o = model.options;
  BalanceState::FootState& foot = state.feet[f];
  const ScheduledFoot planned = model.schedule.at(f, state.time);
  // Pose of the foot at its landing
  Pose X = model.ref.X_WB[at(model.feet[f].link)];
  if (!foot.reacts && !planned.stands && planned.next) X = to_pose({state.x, state.y, state.z, state.heading}) * planned.next->foot;
  const Vec3 wanted = horizontal(X * model.feet[f].sole) + Vec3{foot.shift[0], foot.shift[1], 0};
  const double share = std::min(1.0, dt / o.shift_time);
  const Vec3 move = choose_move(model, state, f, wanted, X.R);
  for (int k = 0; k < 2; ++k) foot.place[k] += (move[k] - foot.place[k]) * share;
  const Vec3 to = wanted + Vec3{foot.place[0], foot.place[1], 0};
  const Patch ground = under_sole(model, state, f, to, X.R);
  foot.to[0] = to.x;
  foot.to[1] = to.y;
  foot.to[2] += (ground.height - foot.to[2]) * share;
  for (int k = 0; k < 2; ++k) foot.tilt[k] += (ground.tilt[k] - foot.tilt[k]) * share;
  // The path rises above the ground between both places. The sole covers some ground ahead and behind.
  const Vec3 from{foot.from[0], foot.from[1], 0}, way = to - from;
  const double distance = norm(way);
  double rough = 0;
  Hump hump;
  if (distance > min_way) {
    const Vec3 reach = way * (norm(half_[f][0]) / distance);
    const double lean = foot.tilt[0] * reach.x + foot.tilt[1] * reach.y;  // m: the sole swings with the slope of its foothold
    std::array<double, Hump::samples> needed{};
    for (std::size_t k = 0; k < Hump::samples; ++k) {
      const double s = Hump::place(k);
      const double line = foot.from[2] + (foot.to[2] - foot.from[2]) * s;
      for (const double side : {-1.0, 0.0, 1.0}) {
        const double height = model.map_height(state, from + way * s + reach * side) + state.loose - line - lean * side;
        needed[k] = std::max(needed[k], height);
        rough = std::max(rough, std::fabs(height));
      }
    }
    hump = hump_over(needed);
  }
  const double bump = std::min(hump.height, model.max_step(state)) + std::min(rough, o.rough_clearance);
  foot.bump += (bump - foot.bump) * share;
  for (int k = 0; k < 2; ++k) foot.sharp[k] += (hump.sharp[k] - foot.sharp[k]) * share;
}

}  // namespace ugoki::control
