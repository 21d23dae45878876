#pragma once
// Shapes on links, for collision and display.

#include <cstdint>
#include <string_view>
#include <utility>

#include "ugoki/mechanism/geometry.h"
#include "ugoki/spatial/spatial.h"

namespace ugoki {

enum class ShapeType : std::uint8_t { sphere, capsule, box, cylinder, ellipsoid, mesh, height_field };

struct Shape {
  ShapeType type = ShapeType::sphere;
  Pose X_BS;                 ///< shape's frame in the link's frame
  double radius = 0;         ///< m; sphere, capsule, cylinder
  double half_length = 0;    ///< m; along the shape's z, from the centre to the centre of a capsule's cap or of a cylinder's end
  Vec3 half_extents;         ///< m; box, ellipsoid: along the shape's x, y, z
  GeometryPtr geometry;      ///< mesh
  HeightFieldPtr field;      ///< height field
  double friction = 0.8;     ///< Coulomb coefficient; a pair uses the geometric mean
  double restitution = 0.0;  ///< 0 ... 1; a pair uses the greater
  bool collides = true;
  bool visible = true;

  static Shape sphere(double radius, const Pose& X_BS = {}) {
    Shape s;
    s.type = ShapeType::sphere;
    s.radius = radius;
    s.X_BS = X_BS;
    return s;
  }
  /// Capsule whose caps are centred on a and b, both in the link's frame.
  static Shape capsule(double radius, const Vec3& a, const Vec3& b) {
    Shape s;
    s.type = ShapeType::capsule;
    s.radius = radius;
    const Vec3 d = b - a;
    s.half_length = 0.5 * norm(d);
    s.X_BS = {to_matrix(rotation_between({0, 0, 1}, normalized(d))), (a + b) * 0.5};
    return s;
  }
  static Shape box(const Vec3& half_extents, const Pose& X_BS = {}) {
    Shape s;
    s.type = ShapeType::box;
    s.half_extents = half_extents;
    s.X_BS = X_BS;
    return s;
  }
  /// Cylinder about the z axis of its frame.
  static Shape cylinder(double radius, double half_length, const Pose& X_BS = {}) {
    Shape s;
    s.type = ShapeType::cylinder;
    s.radius = radius;
    s.half_length = half_length;
    s.X_BS = X_BS;
    return s;
  }
  static Shape ellipsoid(const Vec3& radii, const Pose& X_BS = {}) {
    Shape s = box(radii, X_BS);
    s.type = ShapeType::ellipsoid;
    return s;
  }
  static Shape mesh(GeometryPtr geometry, const Pose& X_BS = {}) {
    Shape s;
    s.type = ShapeType::mesh;
    s.geometry = std::move(geometry);
    s.X_BS = X_BS;
    return s;
  }
  static Shape height_field(HeightFieldPtr field, const Pose& X_BS = {}) {
    Shape s;
    s.type = ShapeType::height_field;
    s.field = std::move(field);
    s.X_BS = X_BS;
    return s;
  }
};

/// "sphere", "capsule" ...
[[nodiscard]] std::string_view name_of(ShapeType type);

/// A box in the shape's frame.
struct Bounds {
  Vec3 low, high;  ///< m
};
/// The smallest box along the shape's axes that holds it. O(vertices) for meshes
[[nodiscard]] Bounds bounds(const Shape& shape);

/// How far [m] the shape reaches from its frame's origin along the unit vector d, in the shape's frame. O(vertices) for
/// meshes and O(heights) for height fields.
[[nodiscard]] double reach(const Shape& shape, const Vec3& d);

/// Mass properties of the shape filled with `density` [kg/m^3], in the link's frame.
/// A mesh whose surface is open encloses nothing: its mass is 0.
[[nodiscard]] Inertia solid_inertia(const Shape& shape, double density);
/// m^3; 0 for a mesh whose surface is open
[[nodiscard]] double volume(const Shape& shape);

}  // namespace ugoki
