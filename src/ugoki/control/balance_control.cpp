#include "ugoki/control/balance_control.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/check.h"
#include "ugoki/control/foot_phase.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::control {

BalanceControl::BalanceControl(MechanismPtr mechanism, std::shared_ptr<const ReferenceMotion> reference, const BalanceOptions& options,
                               double floor, std::optional<GroundMap> ground)
    : model_(std::move(mechanism), std::move(reference), options, floor, ground ? std::move(*ground) : GroundMap(floor)),
      support_(model_),
      ground_(model_),
      hang_(model_),
      program_(model_) {}

BalanceOutput BalanceControl::step(const BalanceInput& in, BalanceState& state, std::span<double> tau) {
  const Mechanism& m = *model_.mechanism;
  const BalanceOptions& o = model_.options;
  UGOKI_CHECK(tau.size() == model_.v_ref.size() && in.q.size() == model_.q_ref.size() && in.v.size() == tau.size());
  BalanceOutput out;
  // 1., 2. Phase and anchor
  dynamics::update_kinematics(m, in.q, in.v, model_.now);
  model_.centroid = dynamics::calc_centroidal(m, model_.now);
  model_.carry(in.held);
  model_.sample_reference(state);
  support_.collect(model_, in);
  hang_.update(model_, support_, in, state);
  const bool airborne = HangPlan::is_airborne(state);
  if (airborne) {
    hang_.place_reference(model_, state);
  } else {
    update_phase(model_, support_, in.dt, state);
    anchor_.update(model_, in.dt, state);
  }
  ground_.update(model_, support_, in.dt, state);
  model_.sample_reference(state);
  hang_.edit_reference(model_, in, state);
  support_.find_bearing(model_, state);

  // 3. Centre of mass
  const double w0 = std::sqrt(norm(o.gravity) / std::max(0.05, model_.want.centre.z - model_.floor - state.z));
  model_.w0 = w0;
  // The reference moves from one foot to the other at the velocity u for the remaining time T. A DCM that is ahead of the reference by u /
  // w0 (1 - exp(-w0 T)) arrives without effort.
  Vec3 e = model_.centroid.centre - model_.want.centre;
  Vec3 e_rate = model_.centroid.velocity - model_.want.velocity - anchor_.rate() * (1 - exp(-w0 * anchor_.rest()));
  // On a slope, the centre of mass rises with the ground.
  e.z -= model_.ground_rise(state, model_.centroid.centre);
  e_rate.z -= ground_.climb() + state.tilt[0] * model_.centroid.velocity.x + state.tilt[1] * model_.centroid.velocity.y;
  out.dcm_error = horizontal(e + e_rate / w0);
  if (airborne) out.dcm_error = {};

  // 4., 5. Steps
  if (!airborne) planner_.start_reaction(model_, support_, in.dt, state);
  const Vec3 lean = airborne ? Vec3{} : planner_.update_shifts(model_, support_, in.dt, out.dcm_error, state);

  Vec3 acceleration = model_.want_rate.v / model_.mass() - (e - lean) * (w0 * o.com_gain) - e_rate * (w0 + o.com_gain);
  acceleration.z = model_.want_rate.v.z / model_.mass() - e.z * o.height_frequency * o.height_frequency - e_rate.z * 2 * o.height_frequency;

  if (static_cast<HangMode>(state.hang) == HangMode::lands) acceleration.z = std::min(acceleration.z, o.landing_brake * norm(o.gravity));
  out.hang = static_cast<HangMode>(state.hang);

  // 6. Quadratic program
  program_.solve(model_, support_, in, acceleration, hang_.release(), state, tau, out);
  state.time += state.rate * in.dt;
  state.clock += in.dt;
  return out;
}

}  // namespace ugoki::control
