#pragma once
// Mesh files that a description names: their vertices and triangles, and a box around them; internal to robot_formats.

#include <array>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/mechanism/shape.h"

namespace ugoki::robot_formats {

/// Lengths in units of the file; m for COLLADA, which tells its unit.
struct MeshFile {
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> triangles;  ///< indices of points, counter-clockwise seen from outside
};

/// STL (binary, ASCII), OBJ or COLLADA, by the ending of the name. Refuses what is broken, has no vertex, or one that is not
/// finite or beyond 1e6. Memory: a fixed multiple of the file's.
[[nodiscard]] Result<MeshFile> read_mesh(std::string_view bytes, std::string_view file_name);

/// The box around the points along the frame's axes or along the points' principal axes, whichever is smaller; no side
/// is thinner than 0.2 mm. In the points' frame. At least one point.
[[nodiscard]] Shape box_around(const std::vector<Vec3>& points);

}  // namespace ugoki::robot_formats
