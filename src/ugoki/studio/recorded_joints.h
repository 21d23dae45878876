#pragma once
// Displacements of joints, computed from the poses of links in recorded display frames.

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "ugoki/mechanism/mechanism.h"

namespace ugoki::studio {

/// Displacement of a joint from its neutral position. Angles are within -pi to pi. @param X_PB pose of the link in its parent's frame
/// @return the components, of which the first nv are used; zeros for floating joints, whose coordinates depend on the place of the clip
[[nodiscard]] std::array<double, 6> displacement_of(const Joint& joint, const Pose& X_PB);

/// Adds multiples of 2 pi to angles, so that neighbouring samples differ by at most pi.
void unwrap(std::span<double> angles);

/// Pose of a link in a display frame (docs/studio-protocol.md). Requires a frame that contains the character and the link.
[[nodiscard]] Pose link_pose(std::span<const std::byte> frame, std::size_t character, int link);

}  // namespace ugoki::studio
