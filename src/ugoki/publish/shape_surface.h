#pragma once
// Triangle surfaces of shapes, for files of other tools.

#include <array>
#include <cstdint>
#include <vector>

#include "ugoki/mechanism/mechanism.h"

namespace ugoki::publish {

/// A triangle surface with a normal at each vertex. Triangles are counter-clockwise seen from outside.
struct Surface {
  std::vector<Vec3> points;   ///< m
  std::vector<Vec3> normals;  ///< unit vectors, one for each point
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// Appends the surface of a shape, in the frame of its link. Round shapes have vertices on their exact surface, so the triangles are inside
/// the shape; the deviation is below 1 % of the radius. Meshes keep their triangles, with flat shading.
void add_surface(const Shape& shape, Surface& out);

/// Returns the surface of all visible shapes of a link, in the link's frame.
[[nodiscard]] Surface link_surface(const Link& link);

}  // namespace ugoki::publish
