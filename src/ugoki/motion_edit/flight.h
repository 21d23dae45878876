#pragma once
// Phases in which no foot bears: there a body's centre of mass falls.

#include <cstdint>
#include <span>
#include <vector>

#include "ugoki/motion/motion.h"

namespace ugoki::motion_edit {

/// Height of the centre of mass in every frame. [frames] m
[[nodiscard]] std::vector<double> centre_heights(const Mechanism& mechanism, const Motion& motion);

/// Mean vertical acceleration of the heights over the frames in which nothing bears, m/s^2, from the change of velocity over each flight.
/// @param bears [frames] 1 while any foot bears  @param frames of flight that count (out), 0: there is none
[[nodiscard]] double flight_acceleration(std::span<const double> heights, std::span<const std::uint8_t> bears, double rate, int& frames);

/// Raise of the root in every frame, [frames] m, smooth and small, that brings the mean acceleration in each flight to `wanted` [m/s^2];
/// while feet bear the body is pushed up as much more.
[[nodiscard]] std::vector<double> raise_for_flight(std::span<const double> heights, std::span<const std::uint8_t> bears, double rate,
                                                   double wanted);

}  // namespace ugoki::motion_edit
