#pragma once
// A world for tests of closed link systems: the four-bar of the benchmarks (y up), at rest with its crank at 1 rad, and a ball.

#include "../dynamics/benchmark_mechanisms.h"
#include "small_world.h"

namespace ugoki::lsi {

struct ClosedWorld {
  std::unique_ptr<World> world;

  ClosedWorld() {
    const testing::ClosedCase bars = testing::four_bar({}, 1.0, 0);
    std::vector<CharacterSpec> specs(2);
    specs[0].id = "four-bar";
    specs[0].mechanism = bars.mechanism;
    specs[0].q0 = bars.q;
    specs[1].id = "ball";
    specs[1].mechanism = make_ball();
    world = std::make_unique<World>(std::move(specs), std::vector<ScheduledEvent>{}, testing::gravity_y, collision::Ground{});
  }
};

}  // namespace ugoki::lsi
