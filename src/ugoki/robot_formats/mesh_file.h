#pragma once
// Reads the vertices and triangles of a mesh file, and fits a box around them. Internal to robot_formats.

#include <array>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/mechanism/shape.h"

namespace ugoki::robot_formats {

/// Vertices and triangles of a mesh file. Lengths are in the unit of the file, or in m for COLLADA, which states its unit.
struct MeshFile {
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> triangles;  ///< indices into points, counter-clockwise as seen from outside
};

/// Reads an STL (binary or ASCII), OBJ or COLLADA file; the file name extension selects the format. Errors: a damaged file, no vertex, more
/// than 100 million vertices, a coordinate that is not finite or greater than 1e6. Memory: a constant multiple of the file size.
[[nodiscard]] Result<MeshFile> read_mesh(std::string_view bytes, std::string_view file_name);

/// Returns a box around the points, parallel to the axes of their frame; or parallel to the principal axes of the points, if this box has
/// less than 90 % of the volume. Each side is at least 0.2 mm. The box's pose is given in the points' frame. Needs at least one point.
[[nodiscard]] Shape box_around(const std::vector<Vec3>& points);

}  // namespace ugoki::robot_formats
