#pragma once
// Shapes of a URDF link; internal to robot_formats.

#include <optional>
#include <vector>

#include "ugoki/robot_formats/geometry.h"

namespace ugoki::robot_formats {

/// `<origin xyz rpy>` of the node; none is the identity.
[[nodiscard]] Pose urdf_origin(XmlFields& xml, pugi::xml_node node);

/// The shapes of its `<collision>` elements, to collide and to be seen; a link that has none gets those of its `<visual>`
/// elements, to be seen only.
[[nodiscard]] std::vector<Shape> read_urdf_shapes(XmlFields& xml, pugi::xml_node link, const RobotOptions& options, Assets& assets);

}  // namespace ugoki::robot_formats
