#include "ugoki/robot_formats/shape_fit.h"

#include <algorithm>
#include <cmath>

namespace ugoki::robot_formats {
namespace {

Shape capsule(double radius, double half_length, const Pose& X_BS) {
  Shape s;
  s.type = ShapeType::capsule;
  s.radius = radius;
  s.half_length = half_length;
  s.X_BS = X_BS;
  return s;
}

}  // namespace

FittedShape fit_cylinder(double radius, double length, const Pose& X_BS, const std::optional<SpinAxis>& spin) {
  if (length > 2 * radius)
    return {capsule(radius, 0.5 * length - radius, X_BS), "A cylinder is taken as a capsule of the same radius and length."};
  const Vec3 axis = X_BS.R.column(2);
  if (spin && std::fabs(dot(axis, spin->direction)) > 0.999 && norm(cross(axis, X_BS.p - spin->point)) < 0.1 * radius)
    return {Shape::sphere(radius, X_BS), "A wheel is taken as a sphere of the same radius."};
  const double half_side = 0.5 * std::sqrt(pi) * radius;
  return {Shape::box({half_side, half_side, 0.5 * length}, X_BS), "A flat cylinder is taken as a box of the same height and volume."};
}

FittedShape fit_ellipsoid(const Vec3& radii, const Pose& X_BS) {
  const int along = radii.x >= radii.y && radii.x >= radii.z ? 0 : radii.y >= radii.z ? 1 : 2;
  const double across = 0.5 * (radii.x + radii.y + radii.z - radii[along]);
  const Vec3 z{along == 0 ? 1.0 : 0.0, along == 1 ? 1.0 : 0.0, along == 2 ? 1.0 : 0.0};
  const Pose X_BZ{X_BS.R * to_matrix(rotation_between({0, 0, 1}, z)), X_BS.p};
  return {capsule(across, std::max(radii[along] - across, 0.0), X_BZ),
          "An ellipsoid is taken as a capsule of the same length and mean thickness."};
}

}  // namespace ugoki::robot_formats
