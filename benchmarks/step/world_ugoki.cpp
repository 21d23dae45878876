// Ugoki's simulation step, computed like world::WorldStepper (src/ugoki/world/world.cpp).

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "source.h"
#include "ugoki/collision/scene.h"
#include "ugoki/contact/contact_search.h"
#include "ugoki/contact/guarded_step.h"
#include "ugoki/contact/stepper.h"

namespace ugoki::benchmarks {
namespace {

constexpr double margin = 0.02;  // m, contact margin: the default of the LSI's parameter

class UgokiWorld final : public StepWorld {
 public:
  explicit UgokiWorld(const StepSource& source)
      : source_(source),
        ground_{.height = 0, .friction = source.friction, .restitution = 0},
        scene_(source.mechanisms, ground_, {.self_collision = true}),
        search_(scene_, margin),
        stepper_(source.mechanisms, {.gravity = {0, 0, -source.gravity}}),
        guard_scene_(source.mechanisms, ground_),
        guard_(guard_scene_, stepper_),
        states_(source.states),
        touches_itself_(source.mechanisms.size()) {
    for (std::size_t s = 0; s < states_.size(); ++s) {
      const Mechanism& m = *source.mechanisms[s];
      poses_.emplace_back(static_cast<std::size_t>(m.link_count()));
      gains_.emplace_back();
      targets_.emplace_back();
      if (source.servo_gain > 0) {
        gains_.back().resize(states_[s].v.size());
        targets_.back().resize(states_[s].v.size());
      }
      for (int i = 0; i < m.nv() && source.servo_gain > 0; ++i)
        if (m.link(m.link_of_dof(i)).joint.type == JointType::revolute)
          gains_.back()[static_cast<std::size_t>(i)] = source.servo_damping + source.dt * source.servo_gain;
    }
    for (std::size_t s = 0; s < states_.size(); ++s) {
      State& x = states_[s];
      motions_.push_back({x.q, x.v});
      systems_.push_back({x.q, x.v, x.tau, {}, gains_[s], targets_[s], &guard_.end()[s]});
    }
  }

  void step() override {
    contacts_ = &search_.find(motions_, source_.dt, guard_.end());
    if (source_.servo_gain > 0) update_servos();
    if (take_step().status != contact::StepStatus::ok) throw std::runtime_error("Ugoki: the step failed");
  }
  void poses(std::vector<Frame>& out) const override {
    out.clear();
    std::vector<Pose> X;
    for (std::size_t s = 0; s < states_.size(); ++s) {
      X.resize(poses_[s].size());
      calc_poses(*source_.mechanisms[s], states_[s].q, X);
      for (std::size_t i = 0; i < source_.links[s].size(); ++i) {
        if (source_.bodies[s].links[i].mass == 0) continue;
        const Pose& pose = X[static_cast<std::size_t>(source_.links[s][i])];
        Frame f;
        for (int r = 0; r < 3; ++r) {
          Vec3 unit;
          unit[r] = 1;
          const Vec3 row = transpose_times(pose.R, unit);
          for (int c = 0; c < 3; ++c) f.R[3 * r + c] = row[c];
          f.p[r] = pose.p[r];
        }
        out.push_back(f);
      }
    }
  }
  [[nodiscard]] double depth() const override {
    double worst = 0;
    for (const collision::ContactPoint& c : *contacts_) worst = std::max(worst, -c.distance);
    return worst;
  }
  [[nodiscard]] int contacts() const override { return static_cast<int>(contacts_->size()); }
  [[nodiscard]] int dofs() const override {
    int sum = 0;
    for (const MechanismPtr& m : source_.mechanisms) sum += m->nv();
    return sum;
  }
  [[nodiscard]] double mass() const override {
    double sum = 0;
    for (const MechanismPtr& m : source_.mechanisms) sum += m->mass();
    return sum;
  }

 private:
  /// Implicit servos, with the velocity v' after the step: gain (target - v') = stiffness (0 - q - dt v') - damping v'.
  void update_servos() {
    for (std::size_t s = 0; s < states_.size(); ++s)
      for (const Link& l : source_.mechanisms[s]->links()) {
        if (l.joint.type != JointType::revolute) continue;
        const auto v = static_cast<std::size_t>(l.v_index);
        targets_[s][v] = -source_.servo_gain * states_[s].q[static_cast<std::size_t>(l.q_index)] / gains_[s][v];
      }
  }

  contact::StepReport take_step() {
    if (contacts_->empty()) {
      const contact::StepReport report = stepper_.step(systems_, *contacts_, source_.dt);
      guard_.set_end(systems_);
      return report;
    }
    std::ranges::fill(touches_itself_, char{0});
    for (const collision::ContactPoint& c : *contacts_)
      if (c.system_a >= 0 && c.system_a == c.system_b) touches_itself_[static_cast<std::size_t>(c.system_a)] = 1;
    for (std::size_t s = 0; s < systems_.size(); ++s) guard_scene_.set_self_collision(static_cast<int>(s), touches_itself_[s] != 0);
    guard_.forget();
    return guard_.step(systems_, *contacts_, source_.dt);
  }

  const StepSource& source_;
  collision::Ground ground_;
  collision::Scene scene_;
  contact::ContactSearch search_;
  contact::Stepper stepper_;
  collision::Scene guard_scene_;
  contact::GuardedStep guard_;
  std::vector<State> states_;
  std::vector<std::vector<Pose>> poses_;
  std::vector<std::vector<double>> gains_, targets_;  // [bodies][nv] of the servos; empty: none
  std::vector<collision::SystemMotion> motions_;
  std::vector<contact::StepSystem> systems_;
  std::vector<char> touches_itself_;
  std::vector<collision::ContactPoint>* contacts_ = nullptr;
};

}  // namespace

StepWorldPtr make_ugoki(const StepSource& source) { return std::make_unique<UgokiWorld>(source); }

}  // namespace ugoki::benchmarks
