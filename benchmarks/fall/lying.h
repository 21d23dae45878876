#pragma once
// Bodies that get up from random lying postures, as the LSI `balance control` does it.

#include <cstdint>

#include "ugoki/mechanism/mechanism.h"
#include "ugoki/world/world.h"

namespace ugoki::bench {

/// A body at rest in a random lying posture: dropped from low height with a random orientation and random joint angles, its joints damped
/// as in FallMode::lie, 2 s later. @param number seed; the same number gives the same posture
world::WorldState lying_state(const MechanismPtr& mechanism, const world::World& world, std::uint64_t number);

struct LyingSettings {
  MechanismPtr mechanism;   ///< body with two arms and two legs
  int count = 40;           ///< number of postures
  std::uint64_t first = 0;  ///< number of the first posture
  bool trace = false;       ///< print one line for each posture
};

struct LyingResult {
  int in_time = 0;  ///< bodies that stand within 6 s
  int stood = 0;    ///< bodies that stand within 20 s
  double time = 0;  ///< s: mean time of the bodies that stand
};

/// A body stands if its centre of mass is above 0.9 times its height in standing and moves slower than 0.2 m/s.
LyingResult run_lying(const LyingSettings& settings);

}  // namespace ugoki::bench
