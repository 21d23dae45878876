#include "ugoki/control/balance_control.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/check.h"
#include "ugoki/control/foot_phase.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::control {
namespace {

/// Rate of the reference's time in an undisturbed step of a walk on uneven ground. The reference was made for level ground: its speed is
/// not the one that its steps have uphill. A walker whose DCM is behind its reference takes its steps later, and one that is ahead takes
/// them earlier. 1 for a character that stands, and before and after flights.
double pace_of(const BalanceModel& model, const BalanceState& state, const Vec3& dcm_error) {
  constexpr double slow = 0.1, walk = 0.2;  // speeds divided by sqrt(g h), h height of the centre of mass
  constexpr double near_flight = 1;         // s
  const BalanceOptions& o = model.options;
  const double uneven = unevenness(model, state);
  const Vec3 velocity = horizontal(model.want.velocity);
  const double speed = norm(velocity), froude = speed * model.w0 / norm(o.gravity);  // w0 = sqrt(g / h)
  if (uneven == 0 || froude <= slow) return 1;
  for (const Flight& f : model.schedule.flights())
    if (f.begin < state.time + near_flight && f.end > state.time - near_flight) return 1;
  const double share = uneven * std::min(1.0, (froude - slow) / (walk - slow));
  const double ahead = dot(dcm_error, velocity) / (speed * speed);  // s
  return 1 + share * std::clamp(ahead / o.pace_time, -o.max_pace, o.max_pace);
}

}  // namespace

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

  // 3. Centre of mass
  const double w0 = std::sqrt(norm(o.gravity) / std::max(0.05, model_.want.centre.z - model_.floor - state.z));
  model_.w0 = w0;
  // The reference moves from one foot to the other. A DCM that is ahead of it by the distance `ahead` arrives without effort.
  Vec3 e = model_.centroid.centre - model_.want.centre;
  Vec3 e_rate = model_.centroid.velocity - model_.want.velocity - (airborne ? Vec3{} : anchor_.ahead(w0) * w0);
  // On a slope, the centre of mass rises with the ground.
  e.z -= model_.ground_rise(state, model_.centroid.centre);
  e_rate.z -= ground_.climb() + state.tilt[0] * model_.centroid.velocity.x + state.tilt[1] * model_.centroid.velocity.y;
  out.dcm_error = horizontal(e + e_rate / w0);
  if (airborne) out.dcm_error = {};

  Vec3 acceleration = model_.want_rate.v / model_.mass() - e * (w0 * o.com_gain) - e_rate * (w0 + o.com_gain);
  acceleration.z = model_.want_rate.v.z / model_.mass() - e.z * o.height_frequency * o.height_frequency - e_rate.z * 2 * o.height_frequency;
  const double load = std::max(0.2 * norm(o.gravity), norm(o.gravity) + acceleration.z);
  const Vec3 pressure = horizontal(model_.centroid.centre - acceleration * ((model_.centroid.centre.z - model_.floor - state.z) / load));
  support_.find_bearing(model_, state, pressure);

  // 4., 5. Steps
  if (!airborne) planner_.start_reaction(model_, support_, in.dt, state);
  const Vec3 lean = airborne ? Vec3{} : planner_.update_shifts(model_, support_, in.dt, out.dcm_error, state);
  acceleration += horizontal(lean) * (w0 * o.com_gain);

  if (static_cast<HangMode>(state.hang) == HangMode::lands) acceleration.z = std::min(acceleration.z, o.landing_brake * norm(o.gravity));
  out.hang = static_cast<HangMode>(state.hang);

  state.pace = airborne ? 1 : pace_of(model_, state, out.dcm_error);

  // 6. Quadratic program
  program_.solve(model_, support_, in, acceleration, hang_.release(), state, tau, out);
  state.time += state.rate * in.dt;
  state.clock += in.dt;
  return out;
}

}  // namespace ugoki::control
