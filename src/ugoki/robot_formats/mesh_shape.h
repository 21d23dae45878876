#pragma once
// The mesh of a description as a shape: its surface, its convex hull, or the box around it. Internal to robot_formats.

#include <string>

#include "ugoki/robot_formats/mesh_file.h"
#include "ugoki/robot_formats/robot_model.h"

namespace ugoki::robot_formats {

struct MeshShape {
  Shape shape;                     ///< in the mesh's frame
  std::vector<std::string> notes;  ///< sentences on what was mended or could not be had
  GeometryFindings found;          ///< exact: what was mended
};

/// A mesh whose points all lie in a plane or on a line has no hull that encloses something: it becomes a thin box, with a note.
/// Errors (at `place`): as make_geometry and make_hull_geometry have them.
/// @param how exact, hull or box
/// @param collides false: only to be seen, so nothing is prepared for collision
[[nodiscard]] Result<MeshShape> shape_of_mesh(const MeshFile& mesh, Meshes how, bool collides, const std::string& place);

/// "A mesh that collides is taken as its convex hull."
[[nodiscard]] std::string how_taken(const Shape& shape, bool collides);

}  // namespace ugoki::robot_formats
