#pragma once
// A simulated character under balance control, for tests.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "ugoki/body/body.h"
#include "ugoki/contact/guarded_step.h"
#include "ugoki/control/balance_control.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion/clip.h"
#include "ugoki/motion/reference.h"
#include "ugoki/motion/torques.h"
#include "ugoki/samples/samples.h"

namespace ugoki::control {

/// A cyclic motion, repeated for `length` seconds.
class Looped final : public ReferenceMotion {
 public:
  Looped(MechanismPtr mechanism, const Motion& motion, double length)
      : mechanism_(std::move(mechanism)), motion_(make_reference(motion, *mechanism_, 0)) {
    if (is_computed(motion)) labels_ = motion.contacts;
    clip_.length = length;
    clip_.loop = motion.cyclic;
    if (motion.cyclic) clip_.cycle = cycle_of(motion, *mechanism_);
  }
  void sample(double t, std::span<double> q, std::span<double> v, std::span<double> a) const override {
    ugoki::sample(clip_, motion_, *mechanism_, t, q, v, a);
  }
  [[nodiscard]] double end() const override { return clip_.length; }
  [[nodiscard]] bool contacts(double t, std::span<std::uint8_t> on) const override {
    if (labels_.empty()) return false;
    const double time = phase_of(clip_, motion_.duration(), t).time;
    const auto frame = static_cast<std::size_t>(std::clamp(std::floor(time * motion_.rate() + 0.5), 0.0, motion_.frames() - 1.0));
    std::ranges::fill(on, std::uint8_t{0});
    for (const ContactTrack& label : labels_)
      for (int i = 0; i < mechanism_->link_count(); ++i)
        if (mechanism_->link(i).name == label.link) on[static_cast<std::size_t>(i)] = label.on[frame];
    return true;
  }

 private:
  MechanismPtr mechanism_;
  SmoothMotion motion_;
  std::vector<ContactTrack> labels_;  // of a computed motion
  Clip clip_;
};

/// Another reference motion, displaced in the plane and turned about the vertical.
class Displaced final : public ReferenceMotion {
 public:
  Displaced(MechanismPtr mechanism, std::shared_ptr<const ReferenceMotion> motion, const Placement& by)
      : mechanism_(std::move(mechanism)), motion_(std::move(motion)), by_(by) {}
  void sample(double t, std::span<double> q, std::span<double> v, std::span<double> a) const override {
    motion_->sample(t, q, v, a);
    displace_root(*mechanism_, by_, q);
    const Mat3 P = mechanism_->link(0).joint.X_PJ.R, turn = P.transposed() * rotation_about({0, 0, 1}, by_.heading) * P;
    for (const std::span<double> x : {v, a}) {
      const Vec3 linear = turn * Vec3{x[3], x[4], x[5]};
      for (int k = 0; k < 3; ++k) x[static_cast<std::size_t>(3 + k)] = linear[k];
    }
  }
  [[nodiscard]] double end() const override { return motion_->end(); }

 private:
  MechanismPtr mechanism_;
  std::shared_ptr<const ReferenceMotion> motion_;
  Placement by_;
};

/// The walking human of the samples.
struct Walker {
  MeasuredMotion walk = samples::make_human_walk();
  body::Body body = body::make_body(walk).value();
};
inline Motion motion_of(const body::Body& body, const MeasuredMotion& measured) {
  Motion motion = body::to_motion(body, measured);
  motion.cyclic = true;
  return motion;
}

/// A character under balance control, on the floor or on a fixed mechanism.
struct Simulation {
  MechanismPtr m;
  std::shared_ptr<const ReferenceMotion> reference;
  std::vector<MechanismPtr> systems;
  BalanceControl control;
  BalanceState memory;
  collision::Scene scene;
  collision::Workspace workspace{scene};
  contact::Stepper stepper;
  contact::GuardedStep guard{scene, stepper};
  State state{*m};
  std::vector<Pose> X{static_cast<std::size_t>(m->link_count())};
  std::vector<collision::ContactPoint> contacts;
  BalanceOutput last;

  Simulation(const body::Body& body, const MeasuredMotion& measured, double length, MechanismPtr terrain = nullptr)
      : Simulation(body.mechanism, std::make_shared<const Looped>(body.mechanism, motion_of(body, measured), length), std::move(terrain)) {}
  /// @param terrain fixed mechanism that replaces the floor; null: the floor
  Simulation(MechanismPtr mechanism, std::shared_ptr<const ReferenceMotion> motion, MechanismPtr terrain = nullptr)
      : m(std::move(mechanism)),
        reference(std::move(motion)),
        systems(terrain ? std::vector{m, terrain} : std::vector{m}),
        control(m, reference, {}, 0, GroundMap(systems, 0, terrain ? -100.0 : 0.0)),
        scene(systems, collision::Ground{terrain ? -100.0 : 0.0}),
        stepper(systems, {}) {
    std::vector<double> a(state.v.size());
    reference->sample(0, state.q, state.v, a);
  }
  void step(const Vec3& push = {}) {
    calc_poses(*m, state.q, X);
    const std::vector<Pose> fixed(1);
    const std::span<const Pose> poses[2] = {X, fixed};
    workspace.forget();
    collision::find_contacts(scene, std::span(poses).first(systems.size()), 0.02, workspace, contacts);
    last = control.step({state.q, state.v, contacts, 0, 0.002}, memory, state.tau);
    for (int i = 0; i < 6; ++i) ASSERT_EQ(state.tau[static_cast<std::size_t>(i)], 0) << "no force may act on the root";
    for (Vec6& w : state.external) w = {};
    for (int i = 0; i < m->link_count(); ++i)
      if (m->link(i).label == "chest") {
        const Vec3 p = X[static_cast<std::size_t>(i)] * m->link(i).inertia.centre();
        state.external[static_cast<std::size_t>(i)] = {cross(p, push), push};
      }
    contact::StepSystem stepped[2] = {{state.q, state.v, state.tau, state.external, {}, {}}, {}};
    guard.forget();
    ASSERT_EQ(guard.step(std::span(stepped).first(systems.size()), contacts, 0.002).status, contact::StepStatus::ok);
  }
  [[nodiscard]] double below() const { return control.reference()[2] - state.q[2]; }  // m, height of the reference root above the root
  /// rms angle of the joints from the reference, degrees.
  [[nodiscard]] double tracking_error() const {
    std::vector<double> e(state.v.size());
    difference(*m, state.q, control.reference(), e);
    double sum = 0;
    for (std::size_t i = 6; i < e.size(); ++i) sum += e[i] * e[i];
    return 180 / pi * std::sqrt(sum / static_cast<double>(e.size() - 6));
  }
};

}  // namespace ugoki::control
