#pragma once
// Shapes of links, for collision and display.

#include <cstdint>
#include <string_view>
#include <utility>

#include "ugoki/mechanism/geometry.h"
#include "ugoki/spatial/spatial.h"

namespace ugoki {

enum class ShapeType : std::uint8_t { sphere, capsule, box, cylinder, ellipsoid, mesh, height_field };

struct Shape {
  ShapeType type = ShapeType::sphere;
  Pose X_BS;                 ///< pose of the shape's frame in the link's frame
  double radius = 0;         ///< m; sphere, capsule, cylinder
  double half_length = 0;    ///< m; capsule: from the centre to a cap's centre along z; cylinder: half its height
  Vec3 half_extents;         ///< m; box, ellipsoid: half sizes along the shape's x, y, z
  GeometryPtr geometry;      ///< surface of a mesh
  HeightFieldPtr field;      ///< heights of a height field
  double friction = 0.8;     ///< Coulomb coefficient; two shapes in contact use the geometric mean
  double restitution = 0.0;  ///< 0 to 1; two shapes in contact use the larger value
  bool collides = true;
  /// Bits of the groups that this shape belongs to, and bits of the groups that it collides with. Two shapes collide if at least one
  /// collides with a group of the other (can_collide()). The ground collides with every shape whose `collides` is true.
  std::uint32_t groups = 1, partners = 1;
  bool smooth = false;  ///< two smooth shapes have no friction with each other; `friction` applies to all other contacts
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
  /// Cylinder about the z axis of the shape's frame.
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

/// Name in files: "sphere", "capsule", ...
[[nodiscard]] std::string_view name_of(ShapeType type);

/// An axis-aligned box in the shape's frame.
struct Bounds {
  Vec3 low, high;  ///< m
};
/// Smallest axis-aligned box around the shape, in the shape's frame. O(vertices) for meshes.
[[nodiscard]] Bounds bounds(const Shape& shape);

/// Support function: maximum of d . p [m] over the points p of the shape, in the shape's frame. d is a unit vector.
/// O(vertices) for meshes, O(heights) for height fields.
[[nodiscard]] double reach(const Shape& shape, const Vec3& d);

/// Whether two shapes may collide: both collide, and one belongs to a group that the other collides with (Shape::groups).
[[nodiscard]] bool can_collide(const Shape& a, const Shape& b);
/// Coulomb coefficient of friction between two shapes.
[[nodiscard]] double pair_friction(const Shape& a, const Shape& b);

/// Mass properties of the shape as a solid of `density` [kg/m^3], in the link's frame. Mass 0 for a mesh with an open surface.
[[nodiscard]] Inertia solid_inertia(const Shape& shape, double density);
/// Volume [m^3]; 0 for a mesh with an open surface.
[[nodiscard]] double volume(const Shape& shape);

}  // namespace ugoki
