#pragma once
// Types for the simulation of many worlds: constant data shared by all worlds (World), the state of one world (WorldState), and the
// working memory of one thread (WorldStepper).

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "ugoki/contact/contact_search.h"
#include "ugoki/contact/scene_step.h"

namespace ugoki::world {

struct WorldOptions {
  contact::StepperOptions stepper;
  collision::Ground ground;
  double margin = 0.02;         ///< m: pairs of shapes with at most this gap become contacts
  bool self_collision = false;  ///< links of one system collide with each other
};

/// Mechanisms, shapes and options. Immutable; any number of states, steppers and threads may share a world.
class World {
 public:
  explicit World(std::vector<MechanismPtr> systems, const WorldOptions& options = {});

  /// Indices of a system's first coordinate and DOF among those of all systems.
  struct Place {
    std::size_t q = 0, v = 0;
  };
  [[nodiscard]] std::span<const MechanismPtr> systems() const { return scene_.systems(); }
  [[nodiscard]] const Place& place(int system) const { return places_[static_cast<std::size_t>(system)]; }
  [[nodiscard]] std::size_t nq() const { return nq_; }  ///< coordinates of all systems
  [[nodiscard]] std::size_t nv() const { return nv_; }  ///< DOFs of all systems
  [[nodiscard]] const collision::Scene& scene() const { return scene_; }
  [[nodiscard]] const WorldOptions& options() const { return options_; }
  /// Number of impulses for which a WorldState has room: 24 for each shape, 3 for each DOF, and 64.
  [[nodiscard]] std::size_t impulse_capacity() const { return 24 * scene_.shapes().size() + 3 * nv_ + 64; }

 private:
  WorldOptions options_;
  collision::Scene scene_;
  std::vector<Place> places_;
  std::size_t nq_ = 0, nv_ = 0;
};

/// State of a world in one block of memory: positions, velocities, impulses of the last step and memory of loops. A stepper that loads a
/// state continues with the same bits as the stepper that stored it. Copying between states of one world allocates nothing and copies only
/// the part in use, about 2 kB for a walking human.
class WorldState {
 public:
  /// All systems in neutral position, at rest. Keeps a pointer to the world, which must outlive this object.
  explicit WorldState(const World& world);
  WorldState(const WorldState& other);
  WorldState& operator=(const WorldState& other);
  WorldState(WorldState&&) noexcept = default;
  WorldState& operator=(WorldState&&) noexcept = default;
  ~WorldState() = default;

  [[nodiscard]] std::span<double> q(int system);  ///< [nq of the system] m | rad | unit quaternions
  [[nodiscard]] std::span<double> v(int system);  ///< [nv of the system] m/s | rad/s
  [[nodiscard]] std::span<const double> q(int system) const { return const_cast<WorldState*>(this)->q(system); }
  [[nodiscard]] std::span<const double> v(int system) const { return const_cast<WorldState*>(this)->v(system); }
  /// The part of the block that is in use.
  [[nodiscard]] std::span<const std::byte> bytes() const { return std::as_bytes(std::span(block_).first(used_)); }
  /// Hash of bytes().
  [[nodiscard]] std::uint64_t hash() const;
  /// Returns false if the stored step had more impulses than World::impulse_capacity(); the impulses beyond the capacity are lost.
  [[nodiscard]] bool is_complete() const { return complete_; }

 private:
  friend class WorldStepper;
  [[nodiscard]] std::span<const contact::Warm> impulses() const;

  const World* world_;
  // q of all systems, v of all systems, LoopMemory of each system, number of impulses, impulses
  std::vector<double> block_;
  std::size_t used_ = 0;  // entries of block_ in use
  bool complete_ = true;
};

/// Drive forces and servos of all systems for one step.
struct WorldControl {
  std::span<const double> tau;             ///< [World::nv()] N | N m; empty: none
  std::span<const double> servo_gain;      ///< [World::nv()] N m s/rad; empty: none
  std::span<const double> servo_velocity;  ///< [World::nv()] rad/s; empty together with servo_gain
};

/// Steps worlds one after the other. Contains the working memory of one thread; a result depends only on the given state and controls.
class WorldStepper {
 public:
  /// World and executor must outlive this object. @param executor threads for the systems of a large world (Stepper::set_executor); null:
  /// the calling thread only
  explicit WorldStepper(const World& world, Executor* executor = nullptr);

  /// Sets the state from which the following steps continue. O(size of the state).
  void load(const WorldState& state);
  /// Computes one step of dt [s]. On failure the positions and velocities are those before the step.
  /// Allocates nothing after warm-up, unless the number of contacts grows.
  contact::StepReport step(const WorldControl& control, double dt);
  /// Writes the present state into `state`. @param state [out] must belong to the same world
  void store(WorldState& state) const;
  /// Contacts of the last step, and in forces() the mean force on body a of each contact [N, world]; see contact::SceneStep.
  [[nodiscard]] std::span<const collision::ContactPoint> contacts() const { return *contacts_; }
  [[nodiscard]] std::span<const Vec3> forces() const { return step_.forces(); }

 private:
  const World* world_;
  contact::ContactSearch search_;
  contact::SceneStep step_;
  std::vector<double> q_, v_, zeros_;  // of all systems; zeros_: drive forces if none are given
  std::vector<collision::SystemMotion> motions_;
  std::vector<contact::StepSystem> systems_;
  std::vector<collision::ContactPoint>* contacts_;
};

}  // namespace ugoki::world
