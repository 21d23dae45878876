#include "ugoki/geometry/prepare.h"

#include <map>
#include <string>
#include <utility>

#include "ugoki/collision/prepared_geometry.h"
#include "ugoki/geometry/make_hull.h"

namespace ugoki::geometry {
namespace {

using collision::Hull;

Result<Hull> hull_of(std::span<const Vec3> points, std::string_view location) {
  Result<Hull> hull = make_hull(points);
  if (!hull)
    for (Problem& p : hull.error().problems) p.location = std::string(location);
  return hull;
}

/// True if the geometry has its hull and, unless convex, its sphere tree.
bool is_prepared(const Geometry& g) {
  return g.prepared && !g.prepared->hull.vertices.empty() && (g.convex || !g.prepared->spheres.empty());
}

}  // namespace

Result<GeometryPtr> make_hull_geometry(std::span<const Vec3> points, std::string_view location) {
  Result<Hull> hull = hull_of(points, location);
  if (!hull) return fail(std::move(hull.error()));
  if (hull->dimension < 3)
    return fail(ErrorCode::structure, std::string(location),
                "All points are in one plane or on one line, so their convex hull encloses no volume.",
                "Use a thin box, or the mesh itself instead of its hull.");
  std::vector<Triangle> triangles;
  for (int f = 0; f < hull->faces(); ++f) {
    const std::span<const std::int32_t> corners = hull->face(f);
    for (std::size_t i = 2; i < corners.size(); ++i) triangles.push_back({corners[0], corners[i - 1], corners[i]});
  }
  const Result<GeometryPtr> geometry = make_geometry(hull->vertices, triangles, true, location);
  if (!geometry) return geometry;
  Result<collision::PreparedPtr> prepared = collision::make_prepared(**geometry, std::move(*hull), {}, location);
  if (!prepared) return fail(std::move(prepared.error()));
  return collision::with_prepared(**geometry, std::move(*prepared));
}

Result<GeometryPtr> prepare(const GeometryPtr& geometry, std::string_view location) {
  if (is_prepared(*geometry)) return geometry;
  Result<Hull> hull = hull_of(geometry->vertices, location);
  if (!hull) return fail(std::move(hull.error()));
  collision::SphereTree spheres;
  if (geometry->prepared) spheres = geometry->prepared->spheres;
  Result<collision::PreparedPtr> prepared = collision::make_prepared(*geometry, std::move(*hull), std::move(spheres), location);
  if (!prepared) return fail(std::move(prepared.error()));
  return collision::with_prepared(*geometry, std::move(*prepared));
}

Result<MechanismPtr> prepare(const MechanismPtr& mechanism) {
  std::map<std::uint64_t, GeometryPtr> done;
  Error problems;
  MechanismSpec spec = mechanism->spec();
  bool changed = false;
  for (LinkSpec& link : spec.links)
    for (Shape& shape : link.shapes) {
      if (shape.type != ShapeType::mesh || !shape.collides || is_prepared(*shape.geometry)) continue;
      changed = true;
      if (const auto it = done.find(shape.geometry->hash); it != done.end()) {
        shape.geometry = it->second;
        continue;
      }
      Result<GeometryPtr> prepared = prepare(shape.geometry, "link " + link.name);
      if (!prepared) {
        problems.problems.insert(problems.problems.end(), prepared.error().problems.begin(), prepared.error().problems.end());
        continue;
      }
      shape.geometry = done.emplace(shape.geometry->hash, std::move(*prepared)).first->second;
    }
  if (!problems.empty()) return fail(std::move(problems));
  if (!changed) return mechanism;
  return Mechanism::make(std::move(spec));
}

}  // namespace ugoki::geometry
