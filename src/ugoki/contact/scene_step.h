#pragma once
// One step of all systems of a scene, from given contacts. A step with contacts is guarded (GuardedStep).

#include <span>
#include <vector>

#include "ugoki/contact/guarded_step.h"

namespace ugoki::contact {

/// Advances the systems of a scene by steps. A step depends only on positions, velocities, stepper().warm() and stepper().loop_memory().
class SceneStep {
 public:
  SceneStep(const std::vector<MechanismPtr>& systems, const collision::Ground& ground, const StepperOptions& options);

  /// Computes systems and islands on the threads of `executor`; null: on the calling thread. Both give the same bits.
  void set_executor(Executor* executor) { stepper_.set_executor(executor); }

  /// Advances all systems by dt [s]. On failure q and v keep their values from before the step.
  /// @param contacts [in, out] contacts of ContactSearch; contacts that the guard finds are appended
  StepReport step(std::span<StepSystem> systems, std::vector<collision::ContactPoint>& contacts, double dt);
  /// [contacts of the last step] N, world: mean force over the step on body a of each contact; empty after a step without contacts.
  [[nodiscard]] std::span<const Vec3> forces() const { return forces_; }
  /// [systems] Kinematics at the end of the last step, if it did not fail. The caller may exchange them for others.
  [[nodiscard]] std::span<dynamics::KnownKinematics> end() { return guard_.end(); }
  [[nodiscard]] Stepper& stepper() { return stepper_; }
  [[nodiscard]] const Stepper& stepper() const { return stepper_; }

 private:
  Stepper stepper_;
  collision::Scene scene_;            // shapes that the guard tests
  GuardedStep guard_;                 // repeats steps that end in penetration, with additional contacts
  std::vector<char> touches_itself_;  // [systems] 1: the system has contacts between its own links
  std::span<const Vec3> forces_;
};

}  // namespace ugoki::contact
