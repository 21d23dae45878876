#include "lying.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "ugoki/control/balance_control.h"
#include "ugoki/control/fall_control.h"
#include "ugoki/control/return_motion.h"
#include "ugoki/control/still_motion.h"
#include "ugoki/dynamics/centroidal.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::bench {
namespace {

constexpr double dt = 0.002;
std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// The drives of recovery and balance control.
class Recovery {
 public:
  Recovery(const MechanismPtr& mechanism, const std::shared_ptr<const control::ReferenceMotion>& track)
      : mechanism_(mechanism), track_(track), fall_(mechanism, {.get_up = true}) {
    for (std::vector<double>* x : {&tau_, &gain_, &velocity_}) x->resize(at(mechanism->nv()));
    memory_.mode = static_cast<std::uint64_t>(control::FallMode::lie);
  }
  world::WorldControl step(const world::WorldState& state, std::span<const collision::ContactPoint> contacts) {
    const std::span<const double> q = state.q(0), v = state.v(0);
    if (!balance_) {
      fall_.step(q, v, contacts, 0, dt, memory_, tau_, gain_, velocity_);
      if (memory_.mode != static_cast<std::uint64_t>(control::FallMode::ready)) return {tau_, gain_, velocity_};
      way_ = std::make_shared<const control::ReturnMotion>(mechanism_, track_, *fall_.plan(), 5.0, 0.0);
      control::BalanceOptions options;  // as the LSI `balance control` after a rise
      options.press_margin = std::numeric_limits<double>::infinity();
      balance_.emplace(mechanism_, way_, options);
      balance_memory_ = {};
      balance_memory_.time = way_->begin();
      const Placement place = way_->placement_at(q, balance_->feet());
      balance_memory_.x = place.x;
      balance_memory_.y = place.y;
      balance_memory_.heading = place.heading;
      memory_ = {};
      return {tau_, gain_, velocity_};
    }
    std::ranges::fill(gain_, 0.0);
    std::ranges::fill(velocity_, 0.0);
    const control::BalanceOutput out = balance_->step({q, v, contacts, 0, dt}, balance_memory_, tau_);
    fall_.check(q, v, balance_->reference(), out.dcm_error, dt, memory_);
    fall_.brace(q, v, dt, memory_, tau_, gain_, velocity_);
    if (memory_.mode > static_cast<std::uint64_t>(control::FallMode::brace)) balance_.reset();
    return {tau_, gain_, velocity_};
  }
  [[nodiscard]] const control::FallState& memory() const { return memory_; }
  [[nodiscard]] bool stands_up() const { return balance_.has_value(); }

 private:
  MechanismPtr mechanism_;
  std::shared_ptr<const control::ReferenceMotion> track_;
  control::FallControl fall_;
  control::FallState memory_;
  std::shared_ptr<const control::ReturnMotion> way_;
  std::optional<control::BalanceControl> balance_;
  control::BalanceState balance_memory_;
  std::vector<double> tau_, gain_, velocity_;
};

}  // namespace

world::WorldState lying_state(const MechanismPtr& mechanism, const world::World& world, std::uint64_t number) {
  const Mechanism& m = *mechanism;
  std::mt19937_64 random(number + 1);
  const auto uniform = [&](double low, double high) { return low + (high - low) * (static_cast<double>(random() >> 11) * 0x1p-53); };
  world::WorldState state(world);
  std::vector<double> turn(at(m.nv()));
  for (int i = 6; i < m.nv(); ++i) {
    const Dof& d = m.dof(i);
    turn[at(i)] = uniform(std::max(d.lower, -1.0), std::min(d.upper, 1.0));
  }
  const std::span<double> q = state.q(0);
  std::vector<double> posture = m.neutral();
  integrate(m, posture, turn, 1, posture);
  // Uniform orientation (Shoemake 1992)
  const double u = uniform(0, 1), a = uniform(0, 2 * pi), b = uniform(0, 2 * pi);
  posture[3] = std::sqrt(1 - u) * ugoki::sin(a);
  posture[4] = std::sqrt(1 - u) * ugoki::cos(a);
  posture[5] = std::sqrt(u) * ugoki::sin(b);
  posture[6] = std::sqrt(u) * ugoki::cos(b);
  std::vector<Pose> X(at(m.link_count()));
  calc_poses(m, posture, X);
  double low = 1e9;
  for (const Pose& pose : X) low = std::min(low, pose.p.z);
  posture[2] += world.options().ground.height + 0.25 - low;  // no part is below the floor
  std::ranges::copy(posture, q.begin());
  control::FallControl fall(mechanism, {});
  control::FallState memory;
  memory.mode = static_cast<std::uint64_t>(control::FallMode::lie);
  std::vector<double> tau(at(m.nv())), gain(tau.size()), velocity(tau.size());
  world::WorldStepper stepper(world);
  stepper.load(state);
  for (int i = 0; i < static_cast<int>(2 / dt); ++i) {
    fall.step(state.q(0), state.v(0), {}, 0, dt, memory, tau, gain, velocity);
    stepper.step({tau, gain, velocity}, dt);
    stepper.store(state);
  }
  return state;
}

LyingResult run_lying(const LyingSettings& settings) {
  const MechanismPtr& m = settings.mechanism;
  world::World world({m});
  world::WorldStepper stepper(world);
  const auto track = std::make_shared<const control::StillMotion>(
      [&] {
        control::FallControl fall(m, {.get_up = true});
        const control::GetUpPlan* plan = fall.make_plan();
        return plan ? plan->way.back().q : m->neutral();
      }(),
      60.0);
  std::vector<Pose> X(at(m->link_count()));
  calc_poses(*m, track->q(), X);
  const double standing = centre_of_mass(*m, X).z;
  dynamics::Workspace ws(*m);
  LyingResult out;
  for (int n = 0; n < settings.count; ++n) {
    world::WorldState state = lying_state(m, world, settings.first + static_cast<std::uint64_t>(n));
    Recovery recovery(m, track);
    std::vector<collision::ContactPoint> contacts;
    stepper.load(state);
    double stood = -1;
    std::string trace;
    std::uint64_t phase = 99;
    for (double t = 0; t < 20 && stood < 0; t += dt) {
      stepper.step(recovery.step(state, contacts), dt);
      stepper.store(state);
      contacts.assign(stepper.contacts().begin(), stepper.contacts().end());
      dynamics::update_kinematics(*m, state.q(0), state.v(0), ws);
      const dynamics::Centroidal c = dynamics::calc_centroidal(*m, ws);
      if (settings.trace && recovery.memory().get_up.phase != phase) {
        phase = recovery.memory().get_up.phase;
        char text[40];
        std::snprintf(text, sizeof text, " %.1f:%d", t, static_cast<int>(phase));
        trace += text;
      }
      if (recovery.stands_up() && c.centre.z > 0.9 * standing && norm(c.velocity) < 0.2) stood = t;
    }
    if (settings.trace) std::printf("%4d: stands %.2f s %s\n", n, stood, trace.c_str());
    out.in_time += stood >= 0 && stood < 6 ? 1 : 0;
    out.stood += stood >= 0 ? 1 : 0;
    out.time += stood >= 0 ? stood : 0;
  }
  if (out.stood > 0) out.time /= out.stood;
  return out;
}

}  // namespace ugoki::bench
