#pragma once
// Convex shapes described by their support mapping: the point that is farthest along a direction. This is all that Gilbert's method needs.

#include <cstdint>

#include "ugoki/collision/hull.h"

namespace ugoki::collision {

/// Kind of the core of a Support.
enum class SupportKind : std::uint8_t { point, segment, box, hull, cylinder, ellipsoid, half_space };

/// A convex shape in its own frame: a core, inflated by `radius`. Distances are computed between the cores, then the radii are subtracted,
/// so that spheres and capsules are exact.
struct Support {
  SupportKind kind = SupportKind::point;
  double radius = 0;           ///< m: distance by which the core is inflated
  Vec3 size;                   ///< m, size of the core; segment: (0, 0, half length); box: half extents; ellipsoid: semi-axes;
                               ///<   cylinder: (radius, radius, half length); other kinds of core: unused
  const Hull* hull = nullptr;  ///< kind hull only; not owned, must outlive this object

  static Support sphere(double radius) { return {SupportKind::point, radius, {}, nullptr}; }
  /// Capsule along z; half_length is the distance from its centre to the centre of a cap.
  static Support capsule(double radius, double half_length) { return {SupportKind::segment, radius, {0, 0, half_length}, nullptr}; }
  static Support box(const Vec3& half_extents, double radius = 0) { return {SupportKind::box, radius, half_extents, nullptr}; }
  /// Cylinder along z; half_length is the distance from its centre to a flat end.
  static Support cylinder(double r, double half_length, double radius = 0) {
    return {SupportKind::cylinder, radius, {r, r, half_length}, nullptr};
  }
  static Support ellipsoid(const Vec3& semi_axes, double radius = 0) { return {SupportKind::ellipsoid, radius, semi_axes, nullptr}; }
  static Support of(const Hull& hull, double radius = 0) { return {SupportKind::hull, radius, {}, &hull}; }
  /// The half-space z <= radius. Two half-spaces have no distance: GilbertStatus::not_bounded.
  static Support half_space(double radius = 0) { return {SupportKind::half_space, radius, {}, nullptr}; }

  friend bool operator==(const Support&, const Support&) = default;
};

/// Result of find_support().
struct SupportPoint {
  Vec3 p;                   ///< m, shape's frame, on the core
  std::int32_t vertex = 0;  ///< hull: vertex index; box: bit i is set if coordinate i is positive; segment: 0 or 1; otherwise 0
};

/// Point of the core with the maximum d . p. Not defined for half-spaces (assertion).
/// @param d shape's frame, not zero, any length
/// @param hint hulls: vertex at which the search starts, for example the result for a similar direction
[[nodiscard]] SupportPoint find_support(const Support& s, const Vec3& d, std::int32_t hint = 0);

/// Returns a point inside the core: m, shape's frame.
[[nodiscard]] Vec3 centre_of(const Support& s);
/// Radius [m] of the sphere about centre_of(s) that contains the shape, including its `radius`; infinite for a half-space.
[[nodiscard]] double bounding_radius(const Support& s);

}  // namespace ugoki::collision
