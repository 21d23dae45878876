#pragma once
// Convex shapes as what Gilbert's method sees of them: the point that lies farthest in a direction.

#include <cstdint>

#include "ugoki/collision/hull.h"

namespace ugoki::collision {

enum class SupportKind : std::uint8_t { point, segment, box, hull, cylinder, ellipsoid, half_space };

/// A convex core and everything within `radius` of it, in the shape's own frame. Distances are computed between cores and
/// the radii subtracted, so that spheres and capsules are exact.
struct Support {
  SupportKind kind = SupportKind::point;
  double radius = 0;           ///< m: added all round the core
  Vec3 size;                   ///< m; segment: (0, 0, half length); box: half extents; cylinder: (radius, radius, half length);
                               ///<   ellipsoid: semi-axes; else unused
  const Hull* hull = nullptr;  ///< kind hull; not owned, must outlive this

  static Support sphere(double radius) { return {SupportKind::point, radius, {}, nullptr}; }
  /// Along z; half_length from the centre to the centre of a cap.
  static Support capsule(double radius, double half_length) { return {SupportKind::segment, radius, {0, 0, half_length}, nullptr}; }
  static Support box(const Vec3& half_extents, double radius = 0) { return {SupportKind::box, radius, half_extents, nullptr}; }
  /// Along z; half_length from the centre to a flat end.
  static Support cylinder(double r, double half_length, double radius = 0) {
    return {SupportKind::cylinder, radius, {r, r, half_length}, nullptr};
  }
  static Support ellipsoid(const Vec3& semi_axes, double radius = 0) { return {SupportKind::ellipsoid, radius, semi_axes, nullptr}; }
  static Support of(const Hull& hull, double radius = 0) { return {SupportKind::hull, radius, {}, &hull}; }
  /// Everything with z <= 0 (and `radius` above it). Against another half-space there is no distance: status not_bounded.
  static Support half_space(double radius = 0) { return {SupportKind::half_space, radius, {}, nullptr}; }

  friend bool operator==(const Support&, const Support&) = default;
};

struct SupportPoint {
  Vec3 p;                   ///< m, shape's frame, on the core
  std::int32_t vertex = 0;  ///< hull: its index; box: bit i set where coordinate i is positive; segment 0, 1; else 0
};

/// Point of the core with the greatest d . p (d not zero); half-space: unbounded, not to be asked.
/// @param hint the vertex of a nearby direction's answer (hulls start from it)
[[nodiscard]] SupportPoint find_support(const Support& s, const Vec3& d, std::int32_t hint = 0);

/// A point inside the core.
[[nodiscard]] Vec3 centre_of(const Support& s);
/// Radius [m] of the sphere about centre_of(s) that holds the shape, its `radius` included; infinite for a half-space.
[[nodiscard]] double bounding_radius(const Support& s);

}  // namespace ugoki::collision
