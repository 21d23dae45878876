#pragma once
// The vertices and triangles of a COLLADA mesh; internal to robot_formats.

#include <string>
#include <string_view>

#include "ugoki/robot_formats/mesh_file.h"

namespace ugoki::robot_formats {

/// Positions [m] and faces (<triangles>, <polylist>, <polygons>) of every geometry that the scene's nodes place, in the scene's
/// own axes (as the viewers of robot descriptions take them); without a scene those of every geometry. Skins and library
/// nodes are not followed.
[[nodiscard]] Result<MeshFile> collada_mesh(std::string_view text, const std::string& file_name);

}  // namespace ugoki::robot_formats
