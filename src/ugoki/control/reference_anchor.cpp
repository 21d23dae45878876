#include "ugoki/control/reference_anchor.h"

#include <algorithm>
#include <cmath>

#include "ugoki/motion/clip.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::control {
namespace {
std::size_t at(int i) { return static_cast<std::size_t>(i); }
}  // namespace

void ReferenceAnchor::update(const BalanceModel& model, double dt, BalanceState& state) {
  // During double support the anchor moves to the foot that landed last.
  int standing = 0;
  double last_begin = -1e300, first_end = 1e300;
  std::size_t last = 0;
  for (std::size_t f = 0; f < model.feet.size(); ++f) {
    if (!state.feet[f].stands) continue;
    ++standing;
    const ScheduledFoot planned = model.schedule.at(f, state.time);
    const double begin = planned.stands ? planned.begin : state.time;
    if (begin > last_begin) last_begin = begin, last = f;
    if (planned.stands) first_end = std::min(first_end, planned.end);
  }
  rate_ = {};
  rest_ = 0;
  if (standing == 0) return;
  double lead = 1, lead_rate = 0;
  if (standing > 1) {
    const double length = first_end - last_begin;
    lead = std::isfinite(length) && length > 0 ? std::clamp((state.time - last_begin) / length, 0.0, 1.0) : 1.0 / standing;
    if (std::isfinite(length) && length > 0 && lead < 1) lead_rate = state.rate / length;
  }
  Vec3 shift, centre;
  double turn = 0;
  for (std::size_t f = 0; f < model.feet.size(); ++f) {
    if (!state.feet[f].stands) continue;
    const double share = standing == 1 ? 1 : f == last ? lead : (1 - lead) / (standing - 1);
    const Pose &X = model.now.X_WB[at(model.feet[f].link)], &X_ref = model.ref.X_WB[at(model.feet[f].link)];
    const Vec3 offset = model.sole(f) - model.reference_sole(f);
    shift += offset * share;
    if (standing > 1) rate_ += horizontal(offset) * (f == last ? lead_rate : -lead_rate / (standing - 1));
    centre += model.reference_sole(f) * share;
    const Vec3 rotation = log_map(to_quat(X.R * X_ref.R.transposed()));
    turn += rotation.z * share;
  }
  if (standing > 1) rest_ = std::max(0.0, first_end - state.time) / state.rate;
  const double follow = std::min(1.0, dt / model.options.anchor_time);
  const double angle = model.options.heading_time > 0 ? turn * std::min(1.0, dt / model.options.heading_time) : 0;
  // Rotates the reference about its standing foot, then translates it.
  const Vec3 pivot = horizontal(centre), moved = pivot - rotation_about({0, 0, 1}, angle) * pivot + horizontal(shift) * follow;
  const Placement next = Placement{moved.x, moved.y, 0, angle} * Placement{state.x, state.y, 0, state.heading};
  state.x = next.x;
  state.y = next.y;
  state.heading = next.heading;
}

}  // namespace ugoki::control
