#pragma once
// Primitive shapes on links, for collision and display.

#include <cstdint>

#include "ugoki/spatial/spatial.h"

namespace ugoki {

enum class ShapeType : std::uint8_t { sphere, capsule, box };

struct Shape {
  ShapeType type = ShapeType::sphere;
  Pose X_BS;                 ///< shape's frame in the link's frame
  double radius = 0;         ///< m; sphere, capsule
  double half_length = 0;    ///< m; capsule: from the centre to the centre of a cap, along the shape's z
  Vec3 half_extents;         ///< m; box: along the shape's x, y, z
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
};

/// Mass properties of the shape filled with `density` [kg/m^3], in the link's frame.
[[nodiscard]] Inertia solid_inertia(const Shape& shape, double density);
/// m^3
[[nodiscard]] double volume(const Shape& shape);

}  // namespace ugoki
