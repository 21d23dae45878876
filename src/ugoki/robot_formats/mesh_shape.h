#pragma once
// Converts the mesh of a description to a shape: its exact surface, its convex hull, or the box around it. Internal to robot_formats.

#include <string>

#include "ugoki/robot_formats/mesh_file.h"
#include "ugoki/robot_formats/robot_model.h"

namespace ugoki::robot_formats {

/// Shape made from a mesh.
struct MeshShape {
  Shape shape;                     ///< in the mesh's frame
  std::vector<std::string> notes;  ///< sentences for the user about repairs and approximations
  GeometryFindings found;          ///< exact surfaces only: defects found in the mesh
};

/// Makes the shape. If all points are in a plane or on a line, the convex hull has no volume; the result is then a thin box, with a note.
/// Errors (at `location`): the errors of make_geometry and make_hull_geometry.
/// @param how exact surface, hull or box; for a mesh without triangles the exact surface is replaced by the hull
/// @param collides false: the shape is for display only, so that nothing is prepared for collision detection
[[nodiscard]] Result<MeshShape> shape_of_mesh(const MeshFile& mesh, Meshes how, bool collides, const std::string& location);

/// Returns a note for the user about the form in which a mesh is used, for example "A collision mesh is replaced by its convex hull."
[[nodiscard]] std::string describe_mesh_use(const Shape& shape, bool collides);

}  // namespace ugoki::robot_formats
