#include "ugoki/control/reference_anchor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "ugoki/motion/clip.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::control {
namespace {
std::size_t at(int i) { return static_cast<std::size_t>(i); }

using Weights = std::array<double, BalanceState::max_feet>;
}  // namespace

/// Puts the reference a little ahead of the standing foot, in the direction of its own place and heading. Each step then ends nearer to
/// them, because a foot lands by the growing error of the DCM. Without this, the errors of all steps add up: a character that turns along a
/// path leaves it by a tenth of its length. @param centre m, world: standing foot of the displaced reference
void ReferenceAnchor::home(const BalanceModel& model, const BalanceState& state, const Vec3& centre, Vec3& shift, double& turn) {
  const Vec3 own = to_pose(inverse(Placement{state.x, state.y, 0, state.heading})) * horizontal(centre);
  const Vec3 left = model.left(), away = left * dot(horizontal(centre) - own, left);
  const double level = std::max(0.0, 1 - norm(Vec3{state.tilt[0], state.tilt[1], 0}) / model.options.homing_slope);
  const double largest = model.options.max_homing * (model.want.centre.z - model.floor - state.z);
  shift -= away * (level * std::min(model.options.homing, largest / std::max(norm(away), 1e-9)));
  const double turned = std::remainder(state.heading, 2 * pi);
  turn -= std::clamp(model.options.turn_homing * turned, -model.options.max_turn_home, model.options.max_turn_home);
}

void ReferenceAnchor::update(const BalanceModel& model, double dt, BalanceState& state) {
  // The share of a foot grows in the time after it landed and decreases in the time before it lifts. In a walk, the share moves linearly
  // from the rear to the front foot during double support.
  Weights weights{};
  double sum = 0;
  moves_.count = 0;
  moves_.landing = std::numeric_limits<double>::infinity();
  for (std::size_t f = 0; f < model.feet.size(); ++f) {
    if (!state.feet[f].stands) {
      moves_.landing = std::min(moves_.landing, std::max(0.0, model.schedule.at(f, state.time).end - state.time));
      continue;
    }
    const ScheduledFoot planned = model.schedule.at(f, state.time);
    const double since = planned.stands ? state.time - planned.begin : 0, until = planned.stands ? planned.end - state.time : 1e300;
    weights[f] = std::max(std::min({since, until, model.options.max_transfer}), 1e-6);
    sum += weights[f];
  }
  if (sum == 0) {
    if (model.flight(state)) {  // The centre of mass flies along a parabola. The reference flies with it.
      state.x += model.centroid.centre.x - model.want.centre.x;
      state.y += model.centroid.centre.y - model.want.centre.y;
    }
    return;
  }
  Vec3 shift, centre;
  double turn = 0;
  for (std::size_t f = 0; f < model.feet.size(); ++f) {
    if (!state.feet[f].stands) continue;
    const double share = weights[f] / sum;
    // A foot without an ankle turns with its leg. The heading then follows the pelvis.
    const std::size_t link = model.feet[f].turns ? at(model.feet[f].link) : 0;
    const Pose &X = model.now.X_WB[link], &X_ref = model.ref.X_WB[link];
    const Vec3 offset = model.sole(f) - model.reference_sole(f);
    shift += offset * share;
    const ScheduledFoot planned = model.schedule.at(f, state.time);
    // A foot that landed early carries load from its touch-down in the reference on.
    const double begin = planned.stands ? planned.begin : planned.end;
    const double end = planned.stands ? planned.end : planned.next ? planned.next->end : planned.end;
    moves_.feet[moves_.count++] = {state.time - begin, end - state.time, horizontal(offset)};
    centre += model.reference_sole(f) * share;
    const Vec3 rotation = log_map(to_quat(X.R * X_ref.R.transposed()));
    turn += rotation.z * share;
  }
  home(model, state, centre, shift, turn);
  moves_.rate = state.rate;
  moves_.max_share = model.options.max_transfer;
  const double follow = std::min(1.0, dt / model.options.anchor_time);
  const double angle = model.options.heading_time > 0 ? turn * std::min(1.0, dt / model.options.heading_time) : 0;
  // Rotates the reference about its standing foot, then translates it.
  const Vec3 pivot = horizontal(centre), moved = pivot - rotation_about({0, 0, 1}, angle) * pivot + horizontal(shift) * follow;
  const Placement next = Placement{moved.x, moved.y, 0, angle} * Placement{state.x, state.y, 0, state.heading};
  state.x = next.x;
  state.y = next.y;
  state.heading = next.heading;
}

Vec3 ReferenceAnchor::ahead(double w0) const {
  if (moves_.count < 2) return {};
  constexpr double h = 0.01;  // s
  constexpr int samples = 60;
  const double decay = exp(-w0 * h);
  double factor = exp(-0.5 * w0 * h);  // in the middle of an interval
  Vec3 sum, before;
  for (int k = 0; k <= samples; ++k) {
    const double s = k * h * moves_.rate;
    Vec3 place;
    double total = 0;
    for (std::size_t f = 0; f < moves_.count; ++f) {
      const Move& foot = moves_.feet[f];
      const double weight = std::max(std::min({foot.since + s, foot.until - s, moves_.max_share}), 1e-6);
      place += foot.offset * weight;
      total += weight;
    }
    if (k > 0 && (total < 1e-4 || s > moves_.landing)) break;  // all feet lift, or another foot carries load, whose offset is not known yet
    place = place / total;
    if (k > 0) {
      sum += (place - before) * factor;
      factor *= decay;
    }
    before = place;
  }
  return sum;
}

}  // namespace ugoki::control
