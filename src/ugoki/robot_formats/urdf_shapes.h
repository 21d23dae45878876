#pragma once
// Reads the shapes of a URDF link. Internal to robot_formats.

#include <optional>
#include <vector>

#include "ugoki/robot_formats/geometry.h"

namespace ugoki::robot_formats {

/// Reads `<origin xyz rpy>` of the node; the identity if it is absent.
[[nodiscard]] Pose urdf_origin(XmlFields& xml, pugi::xml_node node);

/// Reads the shapes of the link's `<collision>` elements, for collision and display. A link without `<collision>` gets the shapes of its
/// `<visual>` elements, for display only.
[[nodiscard]] std::vector<Shape> read_urdf_shapes(XmlFields& xml, pugi::xml_node link, const RobotOptions& options, Assets& assets);

}  // namespace ugoki::robot_formats
