#pragma once
// Finds the floor on which the feet of a motion stand. Internal to correction.

#include "ugoki/motion/motion.h"
#include "ugoki/motion_edit/feet.h"

namespace ugoki::correction {

/// A plane z = height + slope . (p - centre).
struct FloorPlane {
  Vec3 centre;        ///< m: centre of the feet's positions
  double height = 0;  ///< m, at the centre
  Vec3 slope;         ///< dz/dx, dz/dy, 0
  /// Rigid displacement that moves the plane to z = 0 and its centre vertically.
  [[nodiscard]] Pose to_level() const;
};

/// Robust least squares through the lowest points of slow feet. The slope is zero along directions in which the feet cover less than 1 m,
/// and unless it explains the heights clearly better than a level plane.
[[nodiscard]] FloorPlane find_floor(const Mechanism& m, const Motion& motion, std::span<const motion_edit::FootLimb> feet);

}  // namespace ugoki::correction
