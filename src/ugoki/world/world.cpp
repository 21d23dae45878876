#include "ugoki/world/world.h"

#include <algorithm>
#include <cstring>

#include "ugoki/base/check.h"
#include "ugoki/base/hash.h"

namespace ugoki::world {
namespace {

using contact::Warm;
using LoopMemory = contact::Stepper::LoopMemory;
constexpr std::size_t warm_size = sizeof(Warm) / sizeof(double), loop_size = sizeof(LoopMemory) / sizeof(double);
static_assert(sizeof(Warm) % sizeof(double) == 0 && sizeof(LoopMemory) % sizeof(double) == 0);

/// Index in the block of a state at which the number of impulses is stored; the impulses follow.
std::size_t count_at(const World& world) { return world.nq() + world.nv() + world.systems().size() * loop_size; }

}  // namespace

World::World(std::vector<MechanismPtr> systems, const WorldOptions& options)
    : options_(options), scene_(std::move(systems), options.ground, {.self_collision = options.self_collision}) {
  for (const MechanismPtr& m : scene_.systems()) {
    places_.push_back({nq_, nv_});
    nq_ += static_cast<std::size_t>(m->nq());
    nv_ += static_cast<std::size_t>(m->nv());
  }
}

WorldState::WorldState(const World& world)
    : world_(&world), block_(count_at(world) + 1 + world.impulse_capacity() * warm_size), used_(count_at(world) + 1) {
  for (std::size_t s = 0; s < world.systems().size(); ++s) std::ranges::copy(world.systems()[s]->neutral(), q(static_cast<int>(s)).begin());
}

WorldState::WorldState(const WorldState& other)
    : world_(other.world_), block_(other.block_.size()), used_(other.used_), complete_(other.complete_) {
  std::memcpy(block_.data(), other.block_.data(), used_ * sizeof(double));
}

WorldState& WorldState::operator=(const WorldState& other) {
  if (this == &other) return *this;
  block_.resize(other.block_.size());
  world_ = other.world_;
  used_ = other.used_;
  complete_ = other.complete_;
  std::memcpy(block_.data(), other.block_.data(), used_ * sizeof(double));
  return *this;
}

std::span<double> WorldState::q(int system) {
  return std::span(block_).subspan(world_->place(system).q,
                                   static_cast<std::size_t>(world_->systems()[static_cast<std::size_t>(system)]->nq()));
}

std::span<double> WorldState::v(int system) {
  return std::span(block_).subspan(world_->nq() + world_->place(system).v,
                                   static_cast<std::size_t>(world_->systems()[static_cast<std::size_t>(system)]->nv()));
}

std::uint64_t WorldState::hash() const {
  Hash64 hash;
  hash.add(std::span<const double>(block_).first(used_));
  return hash.value();
}

std::span<const Warm> WorldState::impulses() const {
  const std::size_t at = count_at(*world_);
  return {reinterpret_cast<const Warm*>(block_.data() + at + 1), static_cast<std::size_t>(block_[at])};
}

WorldStepper::WorldStepper(const World& world, Executor* executor)
    : world_(&world),
      search_(world.scene(), world.options().margin),
      step_({world.systems().begin(), world.systems().end()}, world.options().ground, world.options().stepper),
      q_(world.nq()),
      v_(world.nv()),
      zeros_(world.nv()) {
  for (std::size_t s = 0; s < world.systems().size(); ++s) {
    const Mechanism& m = *world.systems()[s];
    const World::Place& place = world.place(static_cast<int>(s));
    const std::span<double> q = std::span(q_).subspan(place.q, static_cast<std::size_t>(m.nq()));
    const std::span<double> v = std::span(v_).subspan(place.v, static_cast<std::size_t>(m.nv()));
    motions_.push_back({q, v});
    systems_.push_back({q, v, {}, {}, {}, {}, &step_.end()[s]});
  }
  search_.set_executor(executor);
  step_.set_executor(executor);
  load(WorldState(world));
  contacts_ = &search_.find(motions_, 1e-3);
}

void WorldStepper::load(const WorldState& state) {
  std::memcpy(q_.data(), state.block_.data(), q_.size() * sizeof(double));
  std::memcpy(v_.data(), state.block_.data() + q_.size(), v_.size() * sizeof(double));
  const double* const loops = state.block_.data() + q_.size() + v_.size();
  for (std::size_t s = 0; s < systems_.size(); ++s) {
    LoopMemory memory;
    std::memcpy(&memory, loops + s * loop_size, sizeof memory);
    step_.stepper().set_loop_memory(static_cast<int>(s), memory);
  }
  step_.stepper().set_warm(state.impulses());
}

void WorldStepper::store(WorldState& state) const {
  UGOKI_CHECK(state.world_ == world_);
  std::memcpy(state.block_.data(), q_.data(), q_.size() * sizeof(double));
  std::memcpy(state.block_.data() + q_.size(), v_.data(), v_.size() * sizeof(double));
  double* const loops = state.block_.data() + q_.size() + v_.size();
  for (std::size_t s = 0; s < systems_.size(); ++s) {
    const LoopMemory memory = step_.stepper().loop_memory(static_cast<int>(s));
    std::memcpy(loops + s * loop_size, &memory, sizeof memory);
  }
  const std::span<const Warm> warm = step_.stepper().warm();
  const std::size_t count = std::min(warm.size(), world_->impulse_capacity()), at = count_at(*world_);
  state.complete_ = count == warm.size();
  state.block_[at] = static_cast<double>(count);
  if (count > 0) std::memcpy(state.block_.data() + at + 1, warm.data(), count * sizeof(Warm));
  state.used_ = at + 1 + count * warm_size;
}

contact::StepReport WorldStepper::step(const WorldControl& control, double dt) {
  const auto part = [&](std::span<const double> all, std::size_t s) {
    return all.empty() ? all : all.subspan(world_->place(static_cast<int>(s)).v, systems_[s].v.size());
  };
  const std::span<const double> tau = control.tau.empty() ? std::span<const double>(zeros_) : control.tau;
  UGOKI_CHECK(tau.size() == world_->nv() && control.servo_gain.size() == control.servo_velocity.size());
  for (std::size_t s = 0; s < systems_.size(); ++s) {
    systems_[s].tau = part(tau, s);
    systems_[s].servo_gain = part(control.servo_gain, s);
    systems_[s].servo_velocity = part(control.servo_velocity, s);
  }
  contacts_ = &search_.find(motions_, dt, step_.end());
  return step_.step(systems_, *contacts_, dt);
}

}  // namespace ugoki::world
