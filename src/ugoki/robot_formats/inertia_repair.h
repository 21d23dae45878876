#pragma once
// Moments of inertia that no body can have; internal to robot_formats.

#include <optional>

#include "ugoki/spatial/spatial.h"

namespace ugoki::robot_formats {

/// Where no body has these moments about the centre of mass (one is negative, or above the sum of the other two), moves them
/// to the nearest that a body has: the second moments of mass P = tr(I)/2 1 - I lose their negative eigenvalues, which
/// is the nearest positive semidefinite matrix (Higham 1988). Mass and centre stay. All numbers finite.
/// @return greatest change of a moment, as a share of the greatest moment; nothing where the inertia is possible
std::optional<double> make_possible(Inertia& inertia);

}  // namespace ugoki::robot_formats
