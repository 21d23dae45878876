#pragma once
// Shapes that Ugoki does not have, as those that it has; internal to robot_formats.

#include <optional>

#include "ugoki/mechanism/shape.h"

namespace ugoki::robot_formats {

/// The axis of a revolute joint in the link's frame.
struct SpinAxis {
  Vec3 point, direction;
};

struct FittedShape {
  Shape shape;
  const char* how;  ///< "A cylinder is taken as ..."
};

/// A cylinder about the z axis of X_BS. Long ones become the capsule of the same radius and length; short ones that turn
/// about their axis are wheels and become a sphere, other short ones a box of the same section's area and length.
[[nodiscard]] FittedShape fit_cylinder(double radius, double length, const Pose& X_BS, const std::optional<SpinAxis>& spin);

/// A sphere or a capsule along the longest radius; the other two by their mean.
[[nodiscard]] FittedShape fit_ellipsoid(const Vec3& radii, const Pose& X_BS);

}  // namespace ugoki::robot_formats
