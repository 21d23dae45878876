#include "ugoki/robot_formats/mesh_shape.h"

#include <utility>

#include "ugoki/geometry/prepare.h"

namespace ugoki::robot_formats {
namespace {

void note_findings(const GeometryFindings& found, std::vector<std::string>& notes) {
  if (found.flat_triangles > 0) notes.push_back("Triangles of a mesh without area are left out.");
  if (found.doubled_triangles > 0) notes.push_back("Triangles that a mesh has twice are taken once.");
  if (found.open_edges > 0)
    notes.push_back("The surface of a mesh is not closed: bodies collide with it from both sides, and it encloses no volume.");
  if (found.inside_out) notes.push_back("The triangles of a mesh look inwards; they were turned round.");
}

Result<MeshShape> surface(const MeshFile& mesh, bool collides, const std::string& place) {
  MeshShape out;
  Result<GeometryPtr> geometry = make_geometry(mesh.points, mesh.triangles, false, place, &out.found);
  if (!geometry) return fail(std::move(geometry.error()));
  if (out.found.inside_out) {
    std::vector<Triangle> turned = (*geometry)->triangles;
    for (Triangle& t : turned) std::swap(t[1], t[2]);
    geometry = make_geometry((*geometry)->vertices, turned, false, place);
    if (!geometry) return fail(std::move(geometry.error()));
  }
  if (collides) geometry = geometry::prepare(*geometry, place);
  if (!geometry) return fail(std::move(geometry.error()));
  note_findings(out.found, out.notes);
  out.shape = Shape::mesh(std::move(*geometry));
  return out;
}

}  // namespace

Result<MeshShape> shape_of_mesh(const MeshFile& mesh, Meshes how, bool collides, const std::string& place) {
  if (how == Meshes::exact && !mesh.triangles.empty()) return surface(mesh, collides, place);
  if (how == Meshes::box) return MeshShape{box_around(mesh.points), {}, {}};
  Result<GeometryPtr> hull = geometry::make_hull_geometry(mesh.points, place);
  if (hull) return MeshShape{Shape::mesh(std::move(*hull)), {}, {}};
  if (hull.error().problems[0].code != ErrorCode::structure) return fail(std::move(hull.error()));
  return MeshShape{box_around(mesh.points), {"A mesh that lies in a plane or on a line is taken as a thin box."}, {}};
}

std::string how_taken(const Shape& shape, bool collides) {
  const std::string which = collides ? "A mesh that collides is taken as " : "A mesh to be seen is shown as ";
  if (shape.type == ShapeType::box) return which + "the box around it.";
  return which + (shape.geometry->convex ? "its convex hull." : "its exact surface.");
}

}  // namespace ugoki::robot_formats
