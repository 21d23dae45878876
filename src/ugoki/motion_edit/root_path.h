#pragma once
// The path of a motion's root over the ground, and an operation that bends a motion along another curve.

#include <span>

#include "ugoki/motion_edit/foot_lock.h"

namespace ugoki::motion_edit {

struct PathPoint {
  double x = 0, y = 0;  ///< m
};

struct RootPathOptions {
  bool keep_speed = true;  ///< true: steps keep their length; the character may stop before the curve's end, or continue straight beyond
                           ///< it. false: the path is scaled to the curve's length
  double smoothing = 0.8;  ///< s, averaging time that removes the sway of the root from the path
  bool lock_feet = true;   ///< lock the feet (motion_edit::lock_feet) after the path is bent
  FootContactOptions contacts;
  FootLockOptions lock;
};

/// The smoothed path of the root over the ground: one point for each animation frame. @param smoothing s
[[nodiscard]] std::vector<PathPoint> root_path(const Mechanism& mechanism, const Motion& motion, double smoothing = 0.8);

/// Returns the motion along a smooth curve through the points (centripetal Catmull-Rom). It starts at the first point in the curve's
/// direction; sway, height and heading relative to the path are kept. Errors: the motion does not fit the mechanism; the root cannot move
/// over the ground; fewer than two different points; a path shorter than 0.2 m.
[[nodiscard]] Result<Motion> bend_path(const Mechanism& mechanism, const Motion& motion, std::span<const PathPoint> points,
                                       const RootPathOptions& options = {}, FootLockReport* report = nullptr);

}  // namespace ugoki::motion_edit
