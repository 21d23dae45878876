#include "ugoki/robot_formats/mesh_shape.h"

#include <utility>

#include "ugoki/geometry/prepare.h"

namespace ugoki::robot_formats {
namespace {

void note_findings(const GeometryFindings& found, std::vector<std::string>& notes) {
  if (found.flat_triangles > 0) notes.push_back("Triangles of a mesh that have no area are left out.");
  if (found.doubled_triangles > 0) notes.push_back("Duplicate triangles of a mesh are left out.");
  if (found.open_edges > 0)
    notes.push_back("The surface of a mesh is not closed: bodies collide with it from both sides, and the mesh encloses no volume.");
  if (found.inside_out) notes.push_back("The triangles of a mesh face inwards; they were flipped.");
}

Result<MeshShape> surface(const MeshFile& mesh, bool collides, const std::string& location) {
  MeshShape out;
  Result<GeometryPtr> geometry = make_geometry(mesh.points, mesh.triangles, false, location, &out.found);
  if (!geometry) return fail(std::move(geometry.error()));
  if (out.found.inside_out) {
    std::vector<Triangle> flipped = (*geometry)->triangles;
    for (Triangle& t : flipped) std::swap(t[1], t[2]);
    geometry = make_geometry((*geometry)->vertices, flipped, false, location);
    if (!geometry) return fail(std::move(geometry.error()));
  }
  if (collides) geometry = geometry::prepare(*geometry, location);
  if (!geometry) return fail(std::move(geometry.error()));
  note_findings(out.found, out.notes);
  out.shape = Shape::mesh(std::move(*geometry));
  return out;
}

}  // namespace

Result<MeshShape> shape_of_mesh(const MeshFile& mesh, Meshes how, bool collides, const std::string& location) {
  if (how == Meshes::exact && !mesh.triangles.empty()) return surface(mesh, collides, location);
  if (how == Meshes::box) return MeshShape{box_around(mesh.points), {}, {}};
  Result<GeometryPtr> hull = geometry::make_hull_geometry(mesh.points, location);
  if (hull) return MeshShape{Shape::mesh(std::move(*hull)), {}, {}};
  if (hull.error().problems[0].code != ErrorCode::structure) return fail(std::move(hull.error()));
  return MeshShape{box_around(mesh.points), {"A mesh whose points lie in a plane or on a line is approximated by a thin box."}, {}};
}

std::string describe_mesh_use(const Shape& shape, bool collides) {
  const std::string subject = collides ? "A collision mesh is " : "A visual mesh is ";
  if (shape.type == ShapeType::box) return subject + "replaced by its bounding box.";
  return subject + (shape.geometry->convex ? "replaced by its convex hull." : "used as its exact surface.");
}

}  // namespace ugoki::robot_formats
