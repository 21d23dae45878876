#pragma once
// Directions that turn together with a character about the vertical axis z.

#include "ugoki/spatial/rotation.h"

namespace ugoki {

/// Heading of an orientation: the unit vector in the xy plane to which the twist about z, of the swing-twist decomposition of R, turns the x
/// axis. heading_of(Z R) = Z heading_of(R) for every rotation Z about z. For a rotation by pi about a horizontal axis it is the x axis.
[[nodiscard]] Vec3 heading_of(const Mat3& R);

/// Returns the unit vector perpendicular to the unit vector `n` that is closest to `direction`; any_perpendicular(n) if `direction` is
/// parallel to n. Unlike that of any_perpendicular, the result turns together with n and `direction`.
[[nodiscard]] Vec3 perpendicular_along(const Vec3& n, const Vec3& direction);

}  // namespace ugoki
