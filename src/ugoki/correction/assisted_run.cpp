#include "ugoki/correction/assisted_run.h"

#include <algorithm>
#include <cmath>

#include "ugoki/collision/scene.h"
#include "ugoki/control/motion_control.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::correction {
namespace {

/// Motion control that never gives the motion up. Points that move in the motion may bear load, because rolling bodies touch with points
/// that rise soon.
control::ControlOptions assisted(const Vec3& gravity) {
  control::ControlOptions o;
  o.assist_limit = 5;
  o.patience = 1e6;
  o.release_tilt = o.fall_depth = 100;
  o.planted_speed = 3;
  o.planted_height = 0.1;
  o.sliding_speed = 2;
  o.sliding_limit = 5;
  o.gravity = gravity;
  return o;
}

/// Position, velocity and acceleration of a motion by differences over its frames; it rests after its end.
class Differences {
 public:
  Differences(const Mechanism& m, const Motion& motion) : m_(m), motion_(motion), before_(size(m.nq())), after_(size(m.nq())) {}
  void at(double t, std::vector<double>& q, std::vector<double>& v, std::vector<double>& a) {
    const double h = 1 / motion_.rate;
    sample(motion_, m_, t, q);
    sample(motion_, m_, t - h, before_);
    sample(motion_, m_, t + h, after_);
    difference(m_, before_, q, v);
    difference(m_, q, after_, a);
    for (std::size_t i = 0; i < v.size(); ++i) {
      const double back = v[i] / h, ahead = a[i] / h;
      v[i] = t < h ? ahead : 0.5 * (back + ahead);
      a[i] = t < h ? 0 : (ahead - back) / h;
    }
  }

 private:
  static std::size_t size(int n) { return static_cast<std::size_t>(n); }
  const Mechanism& m_;
  const Motion& motion_;
  std::vector<double> before_, after_;
};

}  // namespace

RecordedRun run_assisted(const MechanismPtr& mechanism, const Motion& motion, const world::World& world, int steps) {
  const Mechanism& m = *mechanism;
  const auto nq = static_cast<std::size_t>(m.nq()), nv = static_cast<std::size_t>(m.nv());
  control::MotionControl control(mechanism, assisted(world.options().stepper.gravity));
  control::ControlState memory;
  world::WorldStepper stepper(world);
  world::WorldState state(world);
  dynamics::Workspace ws(m);
  collision::Workspace contact_memory(world.scene());
  std::vector<collision::ContactPoint> contacts;
  std::vector<Pose> X(static_cast<std::size_t>(m.link_count()));
  std::vector<double> q(nq), v(nv), a(nv), tau(nv), gain(nv), velocity(nv);
  Differences reference(m, motion);
  RecordedRun run;
  reference.at(0, q, v, a);
  std::ranges::copy(q, state.q(0).begin());
  std::ranges::copy(v, state.v(0).begin());
  stepper.load(state);
  const auto record = [&] {
    run.q.emplace_back(state.q(0).begin(), state.q(0).end());
    run.v.emplace_back(state.v(0).begin(), state.v(0).end());
  };
  record();
  double sum = 0;
  for (int k = 0; k < steps; ++k) {
    reference.at(k * run.step, q, v, a);
    calc_poses(m, state.q(0), X);
    const std::span<const Pose> poses(X);
    collision::find_contacts(world.scene(), std::span(&poses, 1), world.options().margin, contact_memory, contacts);
    const control::ControlOutput out = control.step({state.q(0), state.v(0), q, v, a, contacts, 0, run.step}, memory, tau, gain, velocity);
    sum += out.size_bw * out.size_bw;
    std::vector<double> applied = tau;
    dynamics::update_kinematics(m, state.q(0), state.v(0), ws);
    for (std::size_t i = 0; i < 6; ++i)
      applied[i] = dot(ws.S[i].w, out.assist.w + cross(X[0].p - ws.p0, out.assist.v)) + dot(ws.S[i].v, out.assist.v);
    if (stepper.step({applied, gain, velocity}, run.step).status != contact::StepStatus::ok) break;
    stepper.store(state);
    for (std::size_t i = 0; i < nv; ++i) tau[i] = i < 6 ? 0 : tau[i] + gain[i] * (velocity[i] - state.v(0)[i]);
    run.tau.push_back(tau);
    record();
  }
  run.assist_bw = std::sqrt(sum / std::max(1, run.steps()));
  return run;
}

}  // namespace ugoki::correction
