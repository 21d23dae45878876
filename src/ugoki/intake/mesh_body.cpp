#include "ugoki/intake/mesh_body.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

#include "ugoki/base/number.h"
#include "ugoki/geometry/prepare.h"
#include "ugoki/intake/mesh_skin.h"
#include "ugoki/mechanism_edit/mesh_inertia.h"

namespace ugoki::intake {
namespace {

constexpr double half_thickness = 1e-3;               // m, of flat meshes
constexpr double min_size = 1e-3, max_size = 10'000;  // m

/// Smallest and largest coordinates of the vertices that triangles use.
Bounds used_bounds(const scene_formats::MeshScene& scene) {
  const Vec3& first = scene.vertices[static_cast<std::size_t>(scene.parts[0].triangles[0][0])];
  Bounds out{first, first};
  for (const scene_formats::MeshPart& part : scene.parts)
    for (const Triangle& t : part.triangles)
      for (const std::int32_t v : t)
        for (int k = 0; k < 3; ++k) {
          const double x = scene.vertices[static_cast<std::size_t>(v)][k];
          out.low[k] = std::min(out.low[k], x);
          out.high[k] = std::max(out.high[k], x);
        }
  return out;
}

/// Convex hull of points. Points in a plane or on a line get a thickness.
Result<GeometryPtr> solid_hull(const std::vector<Vec3>& points, std::string_view location) {
  Result<GeometryPtr> hull = geometry::make_hull_geometry(points, location);
  if (hull || hull.error().problems[0].code != ErrorCode::structure) return hull;
  std::vector<Vec3> thick;
  for (const Vec3& p : points)
    for (int corner = 0; corner < 8; ++corner)
      thick.push_back(p + Vec3{(corner & 1) != 0 ? 1.0 : -1.0, (corner & 2) != 0 ? 1.0 : -1.0, (corner & 4) != 0 ? 1.0 : -1.0} *
                              half_thickness);
  return geometry::make_hull_geometry(thick, location);
}

/// Points of each connected part of a surface.
std::vector<std::vector<Vec3>> connected_parts(const Geometry& surface) {
  std::vector<std::int32_t> root(surface.vertices.size());
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](std::int32_t v) {
    while (root[static_cast<std::size_t>(v)] != v)
      v = root[static_cast<std::size_t>(v)] = root[static_cast<std::size_t>(root[static_cast<std::size_t>(v)])];
    return v;
  };
  for (const Triangle& t : surface.triangles)
    for (const std::size_t k : {1U, 2U}) root[static_cast<std::size_t>(find(t[k]))] = find(t[0]);
  std::map<std::int32_t, std::vector<Vec3>> parts;
  for (std::size_t v = 0; v < surface.vertices.size(); ++v) parts[find(static_cast<std::int32_t>(v))].push_back(surface.vertices[v]);
  std::vector<std::vector<Vec3>> out;
  for (auto& [first, points] : parts) out.push_back(std::move(points));
  return out;
}

Shape hidden(GeometryPtr hull, bool collides) {
  Shape out = Shape::mesh(std::move(hull));
  out.visible = false;
  out.collides = collides;
  return out;
}

/// Sets volume and inertia of the body: of the enclosed volume, or of the hull if the surface has holes.
Inertia solid_of(const Geometry& whole, const Geometry& hull, std::string_view location, MeshBody& out) {
  const Result<MeshInertia> solid = mesh_inertia(whole.vertices, whole.triangles, location);
  out.closed = solid.has_value();
  out.volume = solid ? solid->volume : hull.solid.mass;
  if (solid) {
    out.changed.insert(out.changed.end(), solid->report.begin(), solid->report.end());
    return solid->inertia;
  }
  out.checks.push_back("The surface encloses no volume: " + solid.error().problems[0].message +
                       " Mass and inertia are those of the convex hull.");
  return {hull.solid.mass * 1000, hull.solid.h * 1000, hull.solid.I * 1000};
}

}  // namespace

Result<MeshBody> make_mesh_body(const scene_formats::MeshScene& scene, const std::string& name, std::string_view location) {
  MeshBody out;
  const Bounds box = used_bounds(scene);
  out.size = box.high - box.low;
  const double extent = std::max({out.size.x, out.size.y, out.size.z});
  if (!(extent >= min_size && extent <= max_size))
    return fail(ErrorCode::range, std::string(location), "The mesh is " + to_text(extent) + " m large.",
                "Set the unit of length in the import options; props are from 1 mm to 10 km large.");
  const Vec3 origin{0.5 * (box.low.x + box.high.x), 0.5 * (box.low.y + box.high.y), box.low.z};
  std::vector<Vec3> vertices = scene.vertices;
  for (Vec3& v : vertices) v = v - origin;

  LinkSpec link;
  link.name = "body";
  std::vector<Triangle> all;
  GeometryFindings found;
  for (const scene_formats::MeshPart& part : scene.parts) {
    all.insert(all.end(), part.triangles.begin(), part.triangles.end());
    Result<GeometryPtr> geometry = make_geometry(vertices, part.triangles, false, location);
    if (!geometry) continue;  // all its triangles are flat; if those of all parts are, the whole is refused below
    geometry = geometry::prepare(*geometry, location);
    if (!geometry) return fail(std::move(geometry.error()));
    Shape shown = Shape::mesh(std::move(*geometry));
    shown.collides = false;
    link.shapes.push_back(std::move(shown));
    out.colors.push_back(part.color);
  }
  const Result<GeometryPtr> whole = make_geometry(vertices, all, false, location, &found);
  if (!whole) return fail(whole.error());
  out.triangles = (*whole)->triangles.size();
  if (found.flat_triangles > 0) out.changed.push_back("Triangles without area are left out.");
  if (found.doubled_triangles > 0) out.changed.push_back("Duplicate triangles are left out.");

  Result<GeometryPtr> hull = solid_hull((*whole)->vertices, location);
  if (!hull) return fail(std::move(hull.error()));
  link.inertia = solid_of(**whole, **hull, location, out);
  link.shapes.push_back(hidden(*hull, true));
  const std::vector<std::vector<Vec3>> parts = connected_parts(**whole);
  out.parts = 1;
  if (parts.size() > max_hull_parts)
    out.checks.push_back("The mesh has " + std::to_string(parts.size()) +
                         " connected parts; it can collide as one hull or with its surface.");
  else if (parts.size() > 1) {
    out.parts = parts.size();
    for (const std::vector<Vec3>& points : parts) {
      Result<GeometryPtr> part = solid_hull(points, location);
      if (!part) return fail(std::move(part.error()));
      link.shapes.push_back(hidden(std::move(*part), false));
    }
  }
  MechanismSpec spec;
  spec.name = name;
  spec.links.push_back(std::move(link));
  spec.skin = make_mesh_skin(scene, vertices, location, out.checks);
  if (spec.skin) spec.skin_bones = {{"body", Mat3::identity(), {}}};
  Result<MechanismPtr> mechanism = Mechanism::make(std::move(spec));
  if (!mechanism) return fail(std::move(mechanism.error()));
  out.mechanism = std::move(*mechanism);
  return out;
}

}  // namespace ugoki::intake
