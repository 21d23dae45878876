#pragma once
// Timing and heights with which the centre of mass of a hand-animated motion obeys gravity.

#include <span>
#include <vector>

#include "ugoki/spatial/vec3.h"

namespace ugoki::intake {

/// What carries the character in a frame.
enum class Support : char {
  ground,
  flight,  ///< nothing is near the floor, and the flight does not suit gravity
  kept     ///< a flight that stays as it is
};

/// Squared playing speed of each frame with which the centre of mass obeys gravity along its path: it falls with 1 g in flights, and on the
/// ground never faster, nor is it pushed with more than 2.75 body weights. Along a path z(s) that is played with the speed r, the
/// acceleration is z'' r^2 + z' r r' = z'' w + z' w' / 2 with w = r^2, linear in w (Verscheure et al., IEEE Trans. Automatic Control 54
/// (2009)): least squares with one-sided penalties. Far from flights and from falls beyond 1.5 g, w stays near 1. Bounds: 0.16 to 9.
/// O(frames)
/// @param centre [frames] m  @param support [frames]  @param rate frames per second
[[nodiscard]] std::vector<double> squared_speeds(std::span<const Vec3> centre, std::span<const Support> support, double rate);

/// Heights [frames] m by which the centre of mass is raised so that flights follow parabolas, where another timing is not sufficient. On
/// the ground the heights are near 0, and no point gets below the floor. Least squares with one-sided penalties. O(frames)
/// @param lowest [frames] m, height of the lowest point above the floor
[[nodiscard]] std::vector<double> flight_heights(std::span<const Vec3> centre, std::span<const double> lowest,
                                                 std::span<const Support> support, double rate);

/// Mean square, over time, of the acceleration of the centre of mass that gravity and the ground cannot cause, in g^2: all that differs
/// from 1 g downwards in flights; on the ground what falls faster, needs more than 2.75 body weights, or more friction than 0.9.
/// @param speeds [frames] squared playing speeds
[[nodiscard]] double impossible_acceleration(std::span<const Vec3> centre, std::span<const Support> support, std::span<const double> speeds,
                                             double rate);

/// First and second derivatives of the centre at a frame, over the window of this module (0.025 s on both sides).
struct Slope {
  Vec3 first, second;  ///< m/s, m/s^2
};
[[nodiscard]] Slope slope_at(std::span<const Vec3> centre, std::size_t frame, double rate);
/// Frames on both sides of a frame that slope_at() uses; the first and the last frames have no slope.
[[nodiscard]] std::size_t slope_margin(double rate);

}  // namespace ugoki::intake
