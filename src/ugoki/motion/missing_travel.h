#pragma once
// Travel that a motion lacks: the standing feet of a character that walks in place slide over the ground.

#include <span>
#include <vector>

#include "ugoki/spatial/vec3.h"

namespace ugoki {

/// One foot (a paw, a hoof) in each frame of a motion.
struct FootTrack {
  std::vector<double> height;  ///< [frames] m, of its lowest point
  std::vector<Vec3> velocity;  ///< [frames] m/s, of the material point that is the lowest one
};

/// The track of a foot of which one point is known. Velocities are mean values over 0.03 s before and after a frame.
/// @param points [frames] m @param rate frames per second
[[nodiscard]] FootTrack foot_track(std::span<const Vec3> points, double rate);

/// Travel that a character lacks.
struct MissingTravel {
  Vec3 velocity;            ///< m/s, horizontal: mean velocity that the character lacks
  bool steady = true;       ///< the standing feet slide with a constant velocity; else their velocity changes, as in walks made by hand
  std::vector<Vec3> shift;  ///< [frames] m, horizontal: displacement of the whole character that makes its standing feet rest; 0 at first
  [[nodiscard]] bool exists() const { return !shift.empty(); }
};

/// Finds the travel of a character that walks in place, as on a treadmill: its standing feet slide in one direction, and the body does not
/// move along with them. Feet that slide to and fro (a dance on the spot), and feet that glide with the body (skating, a long slide) are
/// left alone. The displacement has a constant velocity if most standing feet have one; else its velocity follows the standing feet,
/// smoothed over 0.1 s. O(feet * frames)
/// @param body [frames] m, place of the pelvis or the root  @param rate frames per second  @param leg m, length of a leg
[[nodiscard]] MissingTravel find_missing_travel(std::span<const FootTrack> feet, std::span<const Vec3> body, double rate, double leg);

}  // namespace ugoki
