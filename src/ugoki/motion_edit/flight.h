#pragma once
// Flight phases: frames in which no foot is in contact and the centre of mass is in free fall.

#include <cstdint>
#include <span>
#include <vector>

#include "ugoki/motion/motion.h"

namespace ugoki::motion_edit {

/// Heights [m] of the centre of mass, one for each animation frame.
[[nodiscard]] std::vector<double> centre_heights(const Mechanism& mechanism, const Motion& motion);

/// Mean vertical acceleration [m/s^2] in flight phases, from a least-squares parabola through the heights of each flight.
/// @param heights [frames] m, heights of the centre of mass  @param bears [frames] 1 while any foot is in contact
/// @param rate frames per second  @param frames [out] number of frames in flight phases; 0 if there are none
[[nodiscard]] double flight_acceleration(std::span<const double> heights, std::span<const std::uint8_t> bears, double rate, int& frames);

/// Vertical displacement [m] of the root in every animation frame: a smooth, small correction that brings the mean acceleration of each
/// flight to `wanted` [m/s^2]. The opposite acceleration is distributed over the frames with contact.
[[nodiscard]] std::vector<double> raise_for_flight(std::span<const double> heights, std::span<const std::uint8_t> bears, double rate,
                                                   double wanted);

}  // namespace ugoki::motion_edit
