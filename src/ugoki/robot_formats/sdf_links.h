#pragma once
// Reads inertia and shapes of an SDF link. Internal to robot_formats.

#include <optional>
#include <vector>

#include "ugoki/robot_formats/geometry.h"
#include "ugoki/robot_formats/sdf_frames.h"

namespace ugoki::robot_formats {

/// Reads the inertia in the link frame of the file. @param link frame index of the link
[[nodiscard]] Inertia read_sdf_inertia(XmlFields& xml, SdfFrames& frames, int link);

/// Reads the shapes of the link's `<collision>` elements, for collision and display. A link without `<collision>` gets the shapes of its
/// `<visual>` elements, for display only. The shapes are given in the link frame of the mechanism.
/// @param link frame index of the link  @param X_BF pose of the file's link frame in the link frame of the mechanism
[[nodiscard]] std::vector<Shape> read_sdf_shapes(XmlFields& xml, SdfFrames& frames, int link, const Pose& X_BF, const RobotOptions& options,
                                                 Assets& assets);

}  // namespace ugoki::robot_formats
