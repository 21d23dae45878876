#pragma once
// Replaces physically impossible moments of inertia. Internal to robot_formats.

#include <optional>

#include "ugoki/spatial/spatial.h"

namespace ugoki::robot_formats {

/// Replaces moments of inertia about the centre of mass that no body can have (one is negative or greater than the sum of the other two) by
/// the nearest possible ones. Method: P = tr(I)/2 E - I (E: identity matrix) is the matrix of second moments of mass. Setting its negative
/// eigenvalues to zero gives the nearest positive semidefinite matrix (Higham 1988). Mass and centre of mass are unchanged.
/// All inputs must be finite.
/// @return the maximum change of a moment divided by the largest moment; std::nullopt if the inertia was already possible
std::optional<double> make_physical(Inertia& inertia);

}  // namespace ugoki::robot_formats
