#pragma once
// Ground shapes that a reference motion does not contain: slopes, steps, tiles.

#include "ugoki/mechanism/mechanism.h"

namespace ugoki::bench {

/// Shape of the ground. At most one of the members differs from zero.
struct Terrain {
  double slope = 0;  ///< degrees: slope along the walk, positive upwards, from 1 m in front of the start
  double steps = 0;  ///< m: platforms of this height and 1.5 m length alternate with the level ground
  double tiles = 0;  ///< m: tiles of 0.5 m x 0.5 m have random heights of up to +- this value
  [[nodiscard]] bool level() const { return slope == 0 && steps == 0 && tiles == 0; }
};

/// m: distance from the centre of a terrain to its border. Slopes are larger.
constexpr double terrain_radius = 4;

/// Returns fixed boxes that form the part of an endless terrain around `centre`. Around `start` the terrain is level at height 0.
/// @param start, centre m, world @param direction unit, horizontal: direction of the walk @param friction Coulomb coefficient
MechanismPtr make_terrain(const Terrain& terrain, const Vec3& start, const Vec3& direction, const Vec3& centre, double friction);

}  // namespace ugoki::bench
