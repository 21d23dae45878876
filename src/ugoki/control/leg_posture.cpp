#include "ugoki/control/leg_posture.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "ugoki/dynamics/dynamics.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::control {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

constexpr double turn_weight = 0.1;  // m^2/rad^2: weight of the orientation of a foot against its position
constexpr double damping = 1e-3;     // m^2/rad^2: weight of a change of the joints; a nearly straight knee stays as it is
constexpr double max_change = 0.5;   // rad: of a joint in one iteration
constexpr int iterations = 3;
constexpr double uneven_rise = 0.01, uneven_slope = 0.1;  // m, rise per length: ground with such a deviation is not level

/// Rotation from level ground to ground with the given upward normal.
Mat3 incline_of(const Vec3& normal) {
  const Vec3 axis = cross(Vec3{0, 0, 1}, normal);
  const double sine = norm(axis);
  return sine > 1e-9 ? rotation_about(axis / sine, atan2(sine, normal.z)) : Mat3::identity();
}

/// m, horizontal: where a swing foot shall be now, minus the place of the reference's foot.
Vec3 swing_shift(const BalanceModel& model, const BalanceState& state, std::size_t f) {
  const BalanceState::FootState& foot = state.feet[f];
  const ScheduledFoot planned = model.schedule.at(f, state.time);
  const double length = planned.end - planned.begin;
  const double phase = planned.stands ? 1 : std::isfinite(length) ? (state.time - planned.begin) / length : 0.5;
  const Vec3 from{foot.offset[0], foot.offset[1], 0}, to{foot.shift[0] + foot.place[0], foot.shift[1] + foot.place[1], 0};
  return from + (to - from) * smooth_step(phase).value;
}

}  // namespace

LegPosture::LegPosture(const BalanceModel& model)
    : ws_(*model.mechanism), goal_(model.feet.size()), reaches_(model.feet.size()), dofs_(model.feet.size()) {
  q_.resize(model.q_ref.size());
  zero_.resize(model.v_ref.size());
  step_.resize(model.v_ref.size());
  const Mechanism& m = *model.mechanism;
  for (std::size_t f = 0; f < model.feet.size(); ++f) {
    if (model.feet[f].hip < 0) continue;
    for (int i = model.feet[f].link; i > 0; i = m.link(i).parent) {
      for (int k = 0; k < m.link(i).joint.nv() && dofs_[f].size() < max_dofs; ++k) dofs_[f].push_back(m.link(i).v_index + k);
      if (i == model.feet[f].hip) break;
    }
  }
}

void LegPosture::update(const BalanceModel& model, const BalanceState& state) {
  std::ranges::copy(model.q_ref, q_.begin());
  const double level = model.floor + state.z;  // m: mean height of the ground
  for (std::size_t f = 0; f < model.feet.size(); ++f) {
    const BalanceState::FootState& foot = state.feet[f];
    const bool many = model.feet.size() > 2;
    reaches_[f] = (foot.stands || many) && !dofs_[f].empty() ? 1 : 0;
    if (!reaches_[f]) continue;
    if (!foot.stands) {
      goal_[f] = {model.ref.X_WB[at(model.feet[f].link)].R, model.reference_sole(f) + swing_shift(model, state, f)};
      continue;
    }
    // On level ground, all legs keep the posture of the reference.
    const double rise = foot.to[2] - level, slope = norm(Vec3{foot.tilt[0], foot.tilt[1], 0});
    const double uneven = std::min(1.0, std::fabs(rise) / uneven_rise + slope / uneven_slope);
    goal_[f] = {incline_of(normalized(Vec3{-foot.tilt[0], -foot.tilt[1], 1})) * model.ref.X_WB[at(model.feet[f].link)].R,
                model.reference_sole(f) + Vec3{0, 0, rise + uneven * state.lower}};
    if (many) goal_[f].p = {model.sole(f).x, model.sole(f).y, goal_[f].p.z};
  }
  for (int k = 0; k < iterations; ++k) {
    dynamics::update_kinematics(*model.mechanism, q_, zero_, ws_);
    std::ranges::fill(step_, 0);
    bool moved = false;
    for (std::size_t f = 0; f < model.feet.size(); ++f)
      if (reaches_[f] && move_leg(model, f)) moved = true;
    if (!moved) break;
    integrate(*model.mechanism, q_, step_, 1, q_);
  }
}

bool LegPosture::move_leg(const BalanceModel& model, std::size_t f) {
  const Foot& foot = model.feet[f];
  const Pose& X = ws_.X_WB[at(foot.link)];
  const Vec3 now = X * foot.sole, place = goal_[f].p - now, turn = log_map(to_quat(goal_[f].R * X.R.transposed()));
  if (norm(place) + norm(turn) < 1e-4) return false;
  // Normal equations (J^T W J + damping I) x = J^T W e, solved by a Cholesky factorization.
  const std::size_t n = dofs_[f].size();
  std::array<Vec3, max_dofs> linear, angular;
  std::array<std::array<double, max_dofs>, max_dofs> H;
  std::array<double, max_dofs> x;
  for (std::size_t i = 0; i < n; ++i) {
    const Vec6& S = ws_.S[at(dofs_[f][i])];
    linear[i] = S.v + cross(S.w, now - ws_.p0);
    angular[i] = S.w;
    x[i] = dot(linear[i], place) + turn_weight * dot(angular[i], turn);
    for (std::size_t j = 0; j <= i; ++j)
      H[i][j] = dot(linear[i], linear[j]) + turn_weight * dot(angular[i], angular[j]) + (i == j ? damping : 0);
  }
  for (std::size_t j = 0; j < n; ++j)
    for (std::size_t i = j; i < n; ++i) {
      double sum = H[i][j];
      for (std::size_t k = 0; k < j; ++k) sum -= H[i][k] * H[j][k];
      H[i][j] = i == j ? std::sqrt(sum) : sum / H[j][j];
    }
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < i; ++k) x[i] -= H[i][k] * x[k];
    x[i] /= H[i][i];
  }
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t k = i + 1; k < n; ++k) x[i] -= H[k][i] * x[k];
    x[i] /= H[i][i];
  }
  for (std::size_t i = 0; i < n; ++i) step_[at(dofs_[f][i])] = std::clamp(x[i], -max_change, max_change);
  return true;
}

}  // namespace ugoki::control
