#include "ugoki/collision/prepared_geometry.h"

#include <algorithm>
#include <string>
#include <utility>

namespace ugoki::collision {
namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

/// Fills PreparedGeometry::first_face and faces from the hull.
void list_faces(PreparedGeometry& out) {
  const Hull& hull = out.hull;
  out.first_face.assign(hull.vertices.size() + 1, 0);
  out.faces.resize(hull.corners.size());
  for (const std::int32_t v : hull.corners) ++out.first_face[at(v) + 1];
  for (std::size_t v = 1; v < out.first_face.size(); ++v) out.first_face[v] += out.first_face[v - 1];
  std::vector<std::int32_t> next(out.first_face.begin(), out.first_face.end());
  for (int f = 0; f < hull.faces(); ++f)
    for (const std::int32_t v : hull.face(f)) out.faces[at(next[at(v)]++)] = f;
}

/// Fills PreparedGeometry::across. A side shared by more than two triangles has no adjacent triangle.
void find_neighbours(PreparedGeometry& out) {
  struct Side {
    std::int32_t low, high, triangle, k;
  };
  const std::vector<Triangle>& triangles = out.spheres.triangles;
  std::vector<Side> sides;
  sides.reserve(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t a = triangles[t][k], b = triangles[t][(k + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), static_cast<std::int32_t>(t), static_cast<std::int32_t>(k)});
    }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return a.low != b.low             ? a.low < b.low
           : a.high != b.high         ? a.high < b.high
           : a.triangle != b.triangle ? a.triangle < b.triangle
                                      : a.k < b.k;
  });
  out.across.assign(triangles.size(), {-1, -1, -1});
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t end = i + 1;
    while (end < sides.size() && sides[end].low == sides[i].low && sides[end].high == sides[i].high) ++end;
    if (end == i + 2) {
      out.across[at(sides[i].triangle)][at(sides[i].k)] = sides[i + 1].triangle;
      out.across[at(sides[i + 1].triangle)][at(sides[i + 1].k)] = sides[i].triangle;
    }
    i = end;
  }
}

Result<Hull> hull_of_convex(const Geometry& geometry, const std::string& location) {
  std::vector<std::int32_t> first = {0}, corners;
  for (const Triangle& t : geometry.triangles) {
    corners.insert(corners.end(), t.begin(), t.end());
    first.push_back(static_cast<std::int32_t>(corners.size()));
  }
  Result<Hull> hull = assemble_hull(geometry.vertices, std::move(first), std::move(corners));
  if (!hull)
    return fail(ErrorCode::structure, location, "The mesh is marked as convex but is not: " + hull.error().problems[0].message,
                "Remove \"convex\", or replace the mesh by its convex hull.");
  return hull;
}

}  // namespace

Result<PreparedPtr> make_prepared(const Geometry& geometry, Hull hull, SphereTree spheres, std::string_view location) {
  const std::string where(location);
  auto out = std::make_shared<PreparedGeometry>();
  if (hull.vertices.empty() && geometry.convex) {
    Result<Hull> made = hull_of_convex(geometry, where);
    if (!made) return fail(std::move(made.error()));
    hull = std::move(*made);
  }
  if (hull.vertices.size() > geometry.vertices.size() ||
      (!geometry.convex && !spheres.empty() && spheres.triangles.size() != geometry.triangles.size()))
    return fail(ErrorCode::structure, where, "The prepared collision data belongs to another mesh.", "Remove \"prepared\"; it is rebuilt.");
  if (!geometry.convex && spheres.empty()) {
    Result<SphereTree> made = make_sphere_tree(geometry.vertices, geometry.triangles, location);
    if (!made) return fail(std::move(made.error()));
    spheres = std::move(*made);
  }
  out->hull = std::move(hull);
  out->spheres = std::move(spheres);
  list_faces(*out);
  find_neighbours(*out);
  return out;
}

GeometryPtr with_prepared(const Geometry& geometry, PreparedPtr prepared) {
  auto out = std::make_shared<Geometry>(geometry);
  out->prepared = std::move(prepared);
  return out;
}

}  // namespace ugoki::collision
