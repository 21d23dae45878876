#pragma once
// Reads the shapes of a URDF link. Internal to robot_formats.

#include <optional>
#include <vector>

#include "ugoki/robot_formats/geometry.h"

namespace ugoki::robot_formats {

/// `<origin xyz rpy>` of the node; the identity if absent.
[[nodiscard]] Pose urdf_origin(XmlFields& xml, pugi::xml_node node);

/// The shapes of the link's `<collision>` elements, for collision and display. A link without any gets the shapes of its `<visual>`
/// elements, for display only.
[[nodiscard]] std::vector<Shape> read_urdf_shapes(XmlFields& xml, pugi::xml_node link, const RobotOptions& options, Assets& assets);

}  // namespace ugoki::robot_formats
