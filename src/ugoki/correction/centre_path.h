#pragma once
// The trajectory of the centre of mass that the contact forces can produce. Internal to correction.

#include "ugoki/correction/observe.h"

namespace ugoki::correction {

/// Returns the displacements [frames] m of the centre of mass that make its trajectory physical: parabolas in flights; in contact, the
/// centre of pressure inside the soles, a ground that only pushes, and legs that reach it.
/// @param headroom [frames] m: the legs can lift the body by this much in contact The displacements are smooth, and small where the motion
/// is physical.
[[nodiscard]] std::vector<Vec3> find_centre_displacement(const Observation& o, double gravity, const std::vector<double>& headroom);

/// Returns, for each frame, the time [s] at which it is to be played, so that the centre of mass falls with `gravity` in flights whose
/// acceleration differs by more than 15 % from it. The playing speed changes smoothly within 0.25 s around such a flight.
[[nodiscard]] std::vector<double> find_flight_times(const Observation& o, double gravity, double strength);

}  // namespace ugoki::correction
