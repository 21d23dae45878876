#pragma once
// The ground of `ugoki gait`: a slope, or stairs that begin 1 m ahead; as heights for the gait and as props of a project.

#include <functional>

#include "ugoki/content/scenario.h"
#include "ugoki/motion/motion.h"

namespace ugoki::cli {

struct GaitGround {
  double slope = 0;          ///< deg, rises along x if positive
  double stairs = 0;         ///< m, height of a step; negative: downwards
  double stair_depth = 0.3;  ///< m, length of a step
  [[nodiscard]] bool level() const { return slope == 0 && stairs == 0; }
};

/// Height [m] of the ground at a point (x, y) [m]; empty: level ground.
[[nodiscard]] std::function<double(double, double)> height_of(const GaitGround& ground);

/// Adds the ground to the scenario as props that are fixed in the world, as far as the motion goes: a ramp that begins 1.5 m ahead of the
/// start, or stairs that begin 1 m ahead. Downwards, they begin at a platform at the height of the motion's floor, and the floor of the
/// scenario is at their foot. Error `range`: the ground would be longer than a prop can be, or it has both a slope and stairs.
/// @param motion of a gait on level ground
[[nodiscard]] Result<void> add_ground(const GaitGround& ground, const Motion& motion, content::Scenario& scenario);

}  // namespace ugoki::cli
