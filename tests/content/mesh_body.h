#pragma once
// Mesh bodies of boxes, from which mesh props are made.

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "ugoki/geometry/prepare.h"
#include "ugoki/mechanism/mechanism.h"

namespace ugoki::content::testing {

/// Corners and outward triangles of the box from `low` to `high`, appended to a mesh.
inline void add_box(const Vec3& low, const Vec3& high, std::vector<Vec3>& points, std::vector<Triangle>& triangles) {
  const auto first = static_cast<std::int32_t>(points.size());
  for (int i = 0; i < 8; ++i)
    points.push_back({(i & 1) != 0 ? high.x : low.x, (i & 2) != 0 ? high.y : low.y, (i & 4) != 0 ? high.z : low.z});
  constexpr std::array<std::array<std::int32_t, 4>, 6> faces = {
      {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
  for (const auto& f : faces) {
    triangles.push_back({first + f[0], first + f[1], first + f[2]});
    triangles.push_back({first + f[0], first + f[2], first + f[3]});
  }
}

/// A mesh body as the import makes it: one visible surface, its hull, and the hulls of its boxes.
inline MechanismPtr body_of(const std::vector<std::pair<Vec3, Vec3>>& boxes) {
  std::vector<Vec3> points;
  std::vector<Triangle> triangles;
  LinkSpec link;
  link.name = "body";
  std::vector<Shape> parts;
  for (const auto& [low, high] : boxes) {
    std::vector<Vec3> own;
    std::vector<Triangle> sides;
    add_box(low, high, own, sides);
    add_box(low, high, points, triangles);
    Shape part = Shape::mesh(geometry::make_hull_geometry(own, "part").value());
    part.visible = part.collides = false;
    parts.push_back(part);
    const Vec3 size = high - low;
    const double mass = 1000 * size.x * size.y * size.z;
    link.inertia += Inertia::from_centre(
        mass, (low + high) * 0.5,
        Sym3{size.y * size.y + size.z * size.z, size.x * size.x + size.z * size.z, size.x * size.x + size.y * size.y, 0, 0, 0} *
            (mass / 12));
  }
  Shape shown = Shape::mesh(geometry::prepare(make_geometry(points, triangles, false, "mesh").value(), "mesh").value());
  shown.collides = false;
  Shape hull = Shape::mesh(geometry::make_hull_geometry(points, "hull").value());
  hull.visible = false;
  link.shapes = {shown, hull};
  if (parts.size() > 1) link.shapes.insert(link.shapes.end(), parts.begin(), parts.end());
  MechanismSpec spec;
  spec.name = "table";
  spec.links = {link};
  return Mechanism::make(spec).value();
}

}  // namespace ugoki::content::testing
