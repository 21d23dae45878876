#pragma once
// Trajectory of the centre of mass. Internal to gait.

#include <span>
#include <vector>

#include "ugoki/spatial/vec3.h"

namespace ugoki::gait {

/// What one frame demands of the centre of mass.
struct CentreFrame {
  Vec3 pressure;      ///< m: centre of pressure
  double load = 1;    ///< vertical ground force divided by the mass, m/s^2; 0 in flight
  double height = 1;  ///< m: height of the centre of mass above the centre of pressure
  Vec3 moment;        ///< m^2/s^2: rate of the angular momentum divided by the mass
  double share = 1;   ///< share of the force of a pendulum: 1, or less if the trunk pitches instead
};

/// Solves height c'' = share load (c - p) + (-H'_y, H'_x) / m in both horizontal directions (a pendulum with the given centre of
/// pressure). Of all solutions this is the bounded one: it begins and ends over the centre of pressure. z is not set. O(frames)
[[nodiscard]] std::vector<Vec3> solve_centre(std::span<const CentreFrame> frames, double rate);

/// Solves x'' - b^2 x = a with x = 0 at both ends. O(frames)
[[nodiscard]] std::vector<double> integrate_twice(std::span<const double> a, double b, double rate);

}  // namespace ugoki::gait
