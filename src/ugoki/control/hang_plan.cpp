#include "ugoki/control/hang_plan.h"

#include <algorithm>
#include <cmath>

#include "ugoki/mechanism/state.h"
#include "ugoki/motion/clip.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::control {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

constexpr double effort_frequency = 8;  // rad/s: natural frequency with which the legs follow the swing (critically damped)
constexpr double min_swing = 0.03;      // rad: a body that swings less begins to swing ahead
constexpr double max_landing = 2;       // s: longest time of a landing

HangMode mode_of(const BalanceState& state) { return static_cast<HangMode>(state.hang); }

void change(HangMode mode, BalanceState& state) {
  state.hang = static_cast<std::uint64_t>(mode);
  state.hang_time = 0;
}

/// m, world: mean place of the soles of the reference, at the height of the lowest one.
Vec3 reference_feet(const BalanceModel& model) {
  Vec3 mean;
  double lowest = model.feet.empty() ? 0 : 1e9;
  for (std::size_t f = 0; f < model.feet.size(); ++f) {
    const Vec3 sole = model.reference_sole(f);
    mean += sole / static_cast<double>(model.feet.size());
    lowest = std::min(lowest, sole.z);
  }
  return {mean.x, mean.y, lowest};
}

/// Where the feet will land, relative to the centre of mass at the landing.
struct Landing {
  Vec3 ahead;         // m, horizontal
  double height = 0;  // m: of the centre of mass above the feet
  double flight = 0;  // s: time until then
};
/// @param ground m: height of the ground @param centre, velocity m, m/s, world: of the centre of mass at the begin of the flight
Landing plan_landing(const BalanceModel& model, double ground, const Vec3& centre, const Vec3& velocity) {
  const BalanceOptions& o = model.options;
  const double height = std::max(0.05, model.want.centre.z - reference_feet(model).z);
  const double g = norm(o.gravity), w0 = std::sqrt(g / height);
  // The vertical impulse of the landing m u, with u the speed at the touch-down, and then the weight act at the feet. At the distance x
  // ahead they brake the speed v of the centre of mass, and take away the angular momentum H:  x (w0 + u / height) = v + H / (m height)
  const double fall = std::max(0.0, centre.z - ground - o.landing_leg * height);
  const double u = std::sqrt(velocity.z * velocity.z + 2 * g * fall);
  const Vec3 spin = model.centroid.momentum.w;
  Vec3 ahead = (horizontal(velocity) + Vec3{spin.y, -spin.x, 0} * (o.landing_spin / (model.mass() * height))) / (w0 + u / height);
  const double reach = o.landing_reach * height;
  if (norm(ahead) > reach) ahead = ahead * (reach / norm(ahead));
  const double leg = o.landing_leg * height;
  return {ahead, std::sqrt(std::max(0.25 * leg * leg, leg * leg - dot(ahead, ahead))), (velocity.z + u) / g};
}

/// The same from the present state.
Landing plan_landing(const BalanceModel& model, const BalanceState& state) {
  return plan_landing(model, model.floor + state.z, model.centroid.centre, model.centroid.velocity);
}

}  // namespace

LandingGoal landing_goal(const BalanceModel& model, const BalanceState& state, std::size_t f) {
  const Landing landing = plan_landing(model, state);
  const Vec3 beside = horizontal(model.reference_sole(f) - reference_feet(model));
  return {model.centroid.centre + landing.ahead + beside - Vec3{0, 0, landing.height}, model.centroid.velocity, model.options.gravity};
}

Swing swing_of(const BalanceModel& model, const BalanceInput& in) {
  Vec3 pivot;
  double count = 0;
  for (const HeldPoint& h : in.held)
    if (h.fixed) pivot += h.p, count += 1;
  if (count == 0) return {};
  const Vec3 left = model.left(), ahead = cross(left, Vec3{0, 0, 1});
  const Vec3 r = model.centroid.centre - pivot / count;
  const double x = dot(r, ahead), z = -r.z, length = std::max(0.05, std::sqrt(x * x + z * z));
  Swing swing;
  swing.angle = atan2(x, z);
  swing.rate = (dot(model.centroid.velocity, ahead) * z + model.centroid.velocity.z * x) / (length * length);
  swing.frequency = std::sqrt(norm(model.options.gravity) / length);
  // Potential and kinetic energy as the height of a swing at rest
  const double rise = 1 - cos(swing.angle) + 0.5 * (swing.rate / swing.frequency) * (swing.rate / swing.frequency);
  swing.amplitude = acos(std::clamp(1 - rise, -1.0, 1.0));
  return swing;
}

HangPlan::HangPlan(const BalanceModel& model) : step_(model.v_ref.size()), no_velocity_(model.v_ref.size()) {}

void HangPlan::update_effort(const BalanceModel& model, const BalanceInput& in, BalanceState& state) {
  double wanted = 0;
  if (model.options.swing > 0 && !prepares(model, in, state)) {
    const Swing swing = swing_of(model, in);
    const double min_rate = min_swing * swing.frequency;
    // The legs move in phase with the speed of the swing. The wanted effort leads by the lag of the legs.
    const double lag = 2 * atan2(swing.frequency, effort_frequency), turn = swing.frequency * swing.angle;
    const double share =
        (swing.rate * cos(lag) - turn * sin(lag) + min_rate) / std::sqrt(swing.rate * swing.rate + turn * turn + min_rate * min_rate);
    wanted = std::clamp(share, -1.0, 1.0) * std::clamp((model.options.swing - swing.amplitude) / model.options.swing_range, -1.0, 1.0);
  }
  const double w = effort_frequency;
  state.hang_rate += ((wanted - state.hang_effort) * w * w - 2 * w * state.hang_rate) * in.dt;
  state.hang_effort += state.hang_rate * in.dt;
}

void HangPlan::update(const BalanceModel& model, const GroundSupport& support, const BalanceInput& in, BalanceState& state) {
  bool held = false, touches = false;
  for (const HeldPoint& h : in.held) held = held || h.fixed;
  for (std::size_t f = 0; f < model.feet.size(); ++f) touches = touches || support.touching(f) > 0;
  state.hang_time += in.dt;
  switch (mode_of(state)) {
    case HangMode::none:
      if (held && !touches) change(HangMode::hangs, state);
      break;
    case HangMode::hangs:
      if (touches)
        change(HangMode::lands, state);
      else if (!held)
        change(HangMode::drops, state);
      break;
    case HangMode::drops:
      if (touches)
        change(HangMode::lands, state);
      else if (held)
        change(HangMode::hangs, state);
      break;
    case HangMode::lands: {
      bool all = true;
      for (std::size_t f = 0; f < model.feet.size(); ++f) all = all && state.feet[f].stands;
      if (held && !touches)
        change(HangMode::hangs, state);
      else if (state.hang_time > (all ? model.options.landing_time : max_landing))
        change(HangMode::none, state);
      break;
    }
  }
  const HangMode mode = mode_of(state);
  if (mode == HangMode::hangs)
    update_effort(model, in, state);
  else
    state.hang_effort = state.hang_rate = 0;
  if (mode == HangMode::none) return;
  for (std::size_t f = 0; f < model.feet.size(); ++f) {
    BalanceState::FootState& foot = state.feet[f];
    if (is_airborne(state)) {
      if (foot.stands || !state.started) model.lift(f, state);
    } else if (!foot.stands && !foot.reacts && support.touching(f) > 0) {
      foot.stands = 1;
      foot.early = model.schedule.at(f, state.time).stands ? 0 : 1;
      foot.lost = 0;
    }
  }
  if (is_airborne(state)) {
    state.started = 1;
    state.rate = 1;
    state.trouble = 0;
    state.lower = 0;
  }
}

void HangPlan::place_reference(const BalanceModel& model, BalanceState& state) const {
  if (mode_of(state) == HangMode::hangs) {  // the reference faces as the body does
    const Vec3 left = model.left(),
               wanted = normalized(horizontal(model.ref.X_WB[0].R * transpose_times(model.rest_pelvis, Vec3{0, 1, 0})), {0, 1, 0});
    const double angle = atan2(wanted.x * left.y - wanted.y * left.x, dot(wanted, left));
    const Vec3 pivot = horizontal(model.want.centre), moved = pivot - rotation_about({0, 0, 1}, angle) * pivot;
    const Placement next = Placement{moved.x, moved.y, 0, angle} * Placement{state.x, state.y, 0, state.heading};
    state.x = next.x;
    state.y = next.y;
    state.heading = next.heading;
  }
  // The feet of the reference are where the body would land.
  const Vec3 feet = model.centroid.centre + plan_landing(model, state).ahead, now = reference_feet(model);
  state.x += feet.x - now.x;
  state.y += feet.y - now.y;
}

void HangPlan::plan_release(const BalanceModel& model, const BalanceInput& in, const BalanceState& state) {
  const double t = in.release_in, g = norm(model.options.gravity);
  // Until the release, the centre of mass swings as a point mass on the length L.
  const Swing swing = swing_of(model, in);
  const double w = swing.frequency, length = g / (w * w);
  const double angle = swing.angle * cos(w * t) + swing.rate / w * sin(w * t),
               rate = swing.rate * cos(w * t) - swing.angle * w * sin(w * t);
  const Vec3 left = model.left(), up{0, 0, 1}, ahead = cross(left, up);
  const Vec3 velocity = (ahead * cos(angle) + up * sin(angle)) * (length * rate);
  const Vec3 centre =
      model.centroid.centre + ahead * (length * (sin(angle) - sin(swing.angle))) + up * (length * (cos(swing.angle) - cos(angle)));
  const Landing landing = plan_landing(model, model.floor + state.z, centre, velocity);
  const double height = std::max(0.05, model.want.centre.z - reference_feet(model).z);
  release_.rest = std::max(t, in.dt);
  release_.flight = std::max(landing.flight, 0.05);
  // From the present orientation upright, less the turn until the release, and leaning back so that the feet are ahead
  release_.turn = log_map(to_quat(model.ref.X_WB[0].R * model.now.X_WB[0].R.transposed())) + left * (angle - swing.angle) +
                  cross(landing.ahead, up) / height;
}

void HangPlan::edit_reference(BalanceModel& model, const BalanceInput& in, const BalanceState& state) {
  const Mechanism& m = *model.mechanism;
  const HangMode mode = mode_of(state);
  release_ = {};
  if (mode == HangMode::none) return;
  if (mode != HangMode::hangs) {
    // The track may still hang: its feet are put on the ground.
    const double rise = reference_feet(model).z - model.floor - state.z;
    const Vec3 down = transpose_times(m.link(0).joint.X_PJ.R, Vec3{0, 0, -rise});
    for (int k = 0; k < 3; ++k) model.q_ref[at(k)] += down[k];
    dynamics::update_kinematics(m, model.q_ref, model.v_ref, model.ref);
    model.want.centre.z -= rise;
    return;
  }
  if (prepares(model, in, state)) plan_release(model, in, state);
  std::ranges::copy(in.q.first(7), model.q_ref.begin());
  for (std::size_t i = 0; i < 6; ++i) {
    model.v_ref[i] = in.v[i];
    model.a_ref[i] = 0;
  }
  dynamics::update_kinematics(m, model.q_ref, model.v_ref, model.ref);
  if (state.hang_effort == 0 && state.hang_rate == 0) return;
  const double range = state.hang_effort >= 0 ? model.options.swing_flex : model.options.swing_arch;
  const Vec3 forward = model.left() * -1.0;  // turning about this axis moves a leg ahead
  std::ranges::fill(step_, 0.0);
  for (const Foot& foot : model.feet) {
    if (foot.hip < 0) continue;
    const Link& hip = m.link(foot.hip);
    for (int k = 0; k < hip.joint.nv(); ++k) {
      const auto i = at(hip.v_index + k);
      const double share = dot(model.ref.S[i].w, forward) * range;
      step_[i] = share * state.hang_effort;
      model.v_ref[i] += share * state.hang_rate;
    }
  }
  integrate(m, model.q_ref, step_, 1, model.q_ref);
  dynamics::update_kinematics(m, model.q_ref, model.v_ref, model.ref);
}

}  // namespace ugoki::control
