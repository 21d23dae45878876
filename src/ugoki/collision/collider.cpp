#include "ugoki/collision/collider.h"

#include <algorithm>

namespace ugoki::collision {
namespace {

/// Prepared data of the geometry. A geometry that is declared convex but is not is prepared as a surface of triangles.
PreparedPtr prepared_of(const Geometry& geometry) {
  if (geometry.prepared) return geometry.prepared;
  Result<PreparedPtr> made = make_prepared(geometry, {}, {}, "mesh");
  if (made) return *made;
  Geometry surface;
  surface.vertices = geometry.vertices;
  surface.triangles = geometry.triangles;
  made = make_prepared(surface, {}, {}, "mesh");
  return made ? *made : std::make_shared<const PreparedGeometry>();
}

void set_bound(Collider& out) {
  const Bounds b = bounds(out.shape);
  const Vec3 half = (b.high - b.low) * 0.5;
  out.centre = (b.low + b.high) * 0.5;
  out.half = half;
  out.thickness = std::min({half.x, half.y, half.z});
  switch (out.shape.type) {
    case ShapeType::sphere: out.bound = out.shape.radius; break;
    case ShapeType::capsule: out.bound = out.shape.radius + out.shape.half_length; break;
    case ShapeType::cylinder: out.bound = std::sqrt(half.x * half.x + half.z * half.z); break;
    case ShapeType::ellipsoid: out.bound = std::max({half.x, half.y, half.z}); break;
    case ShapeType::mesh: {
      double maximum = 0;
      for (const Vec3& p : out.shape.geometry->vertices) maximum = std::max(maximum, dot(p - out.centre, p - out.centre));
      out.bound = std::sqrt(maximum);
      break;
    }
    case ShapeType::box:
    case ShapeType::height_field: out.bound = norm(half); break;
  }
  out.reach = norm(out.centre) + out.bound;
}

}  // namespace

Collider make_collider(const Shape& shape) {
  Collider out;
  out.shape = shape;
  switch (shape.type) {
    case ShapeType::sphere: out.support = Support::sphere(shape.radius); break;
    case ShapeType::capsule: out.support = Support::capsule(shape.radius, shape.half_length); break;
    case ShapeType::box: out.support = Support::box(shape.half_extents); break;
    case ShapeType::cylinder: out.support = Support::cylinder(shape.radius, shape.half_length); break;
    case ShapeType::ellipsoid: out.support = Support::ellipsoid(shape.half_extents); break;
    case ShapeType::mesh:
      out.prepared = prepared_of(*shape.geometry);
      out.convex = out.prepared->spheres.empty();
      out.support = Support::of(out.prepared->hull);
      break;
    case ShapeType::height_field: out.convex = false; break;
  }
  set_bound(out);
  return out;
}

}  // namespace ugoki::collision
