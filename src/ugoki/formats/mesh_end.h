#pragma once
// The far end of a bone, estimated from its mesh.

#include <optional>
#include <span>

#include "ugoki/spatial/vec3.h"

namespace ugoki::formats {

/// Returns the mean of the farthest 15 % (by distance) of a mesh's points from the joint, so that a single corner does not decide;
/// std::nullopt if there are no points, or if all of them are at the joint.
/// @param points vertices in the joint's frame, with the joint at the origin, in any unit
[[nodiscard]] std::optional<Vec3> far_end(std::span<const Vec3> points);

}  // namespace ugoki::formats
