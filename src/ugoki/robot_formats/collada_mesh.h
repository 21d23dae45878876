#pragma once
// Vertices and triangles of a COLLADA mesh. Internal to robot_formats.

#include <string>
#include <string_view>

#include "ugoki/robot_formats/mesh_file.h"

namespace ugoki::robot_formats {

/// Reads vertices [m] and faces (<triangles>, <polylist>, <polygons>) of every geometry that a node of the visual scene instantiates, in
/// the axes of the scene. <up_axis> is ignored, as viewers of robot descriptions do. If no node instantiates a geometry, all geometries are
/// used. Skins and <library_nodes> are ignored.
[[nodiscard]] Result<MeshFile> collada_mesh(std::string_view text, const std::string& file_name);

}  // namespace ugoki::robot_formats
