#pragma once
// Many worlds at once: simulates K worlds from given states with given controls, on all threads of an executor.

#include <memory>
#include <span>
#include <vector>

#include "ugoki/base/executor.h"
#include "ugoki/world/world.h"

namespace ugoki::world {

/// Controls of a rollout. For each world and step: the drive forces of all DOFs, optionally followed by servo gains and servo velocities
/// of all DOFs (units: WorldControl).
struct RolloutControls {
  std::span<const double> numbers;  ///< [worlds][steps][size], or [steps][size] if all worlds have equal controls; empty: no drive forces
  std::size_t size = 0;             ///< numbers for one world and step: World::nv(), or 3 World::nv() with servos
};

/// Simulates many states of one world. Owns a WorldStepper for each thread.
class Rollout {
 public:
  /// Makes a WorldStepper for each thread. @param executor null: the calling thread only. World and executor must outlive this object.
  explicit Rollout(const World& world, Executor* executor = nullptr);

  /// Steps every state `steps` times. The results have the same bits as those of one WorldStepper, for every number of threads. A world
  /// whose step fails keeps the state before that step. Allocates nothing after warm-up, unless the number of contacts of a world grows.
  /// @param states [worlds, in and out] states of the world of the constructor
  /// @param reports [worlds, out] combined reports of all steps of each world (StepReport::add); `substeps` is summed too
  void run(std::span<WorldState> states, const RolloutControls& controls, int steps, double dt, std::span<contact::StepReport> reports);

 private:
  const World* world_;
  Executor* executor_;
  std::vector<std::unique_ptr<WorldStepper>> steppers_;  // [workers]
};

}  // namespace ugoki::world
