#pragma once
// Inertia and shapes of an SDF link; internal to robot_formats.

#include <optional>
#include <vector>

#include "ugoki/robot_formats/geometry.h"
#include "ugoki/robot_formats/sdf_frames.h"

namespace ugoki::robot_formats {

/// In the file's frame of the link. @param link index of its frame
[[nodiscard]] Inertia read_sdf_inertia(XmlFields& xml, SdfFrames& frames, int link);

/// The shapes of its `<collision>` elements, to collide and to be seen; a link that has none gets those of its `<visual>`
/// elements, to be seen only. In the mechanism's frame of the link, in which X_BF is the file's.
[[nodiscard]] std::vector<Shape> read_sdf_shapes(XmlFields& xml, SdfFrames& frames, int link, const Pose& X_BF, const RobotOptions& options,
                                                 Assets& assets);

}  // namespace ugoki::robot_formats
