#pragma once
// The way of a motion over the ground, bent along another curve.

#include <span>

#include "ugoki/motion_edit/foot_lock.h"

namespace ugoki::motion_edit {

struct PathPoint {
  double x = 0, y = 0;  ///< m
};

struct RootPathOptions {
  bool keep_speed = true;  ///< steps stay as long as they are: the figure may stop before the curve's end or go on straight beyond it.
                           ///< false: the way is stretched to the curve's length
  double smoothing = 0.8;  ///< s: sway within this time is no part of the way
  bool lock_feet = true;   ///< feet are locked afterwards
  FootContactOptions contacts;
  FootLockOptions lock;
};

/// The smoothed way of the root over the ground, one place a frame.
[[nodiscard]] std::vector<PathPoint> root_path(const Mechanism& mechanism, const Motion& motion, double smoothing = 0.8);

/// The motion along a smooth curve through the points (centripetal Catmull-Rom), beginning at the first one and in the curve's direction;
/// sway, height and heading against the way stay. Errors: the motion does not fit or its root is fixed; fewer than two different points; it
/// goes nowhere.
[[nodiscard]] Result<Motion> bend_path(const Mechanism& mechanism, const Motion& motion, std::span<const PathPoint> points,
                                       const RootPathOptions& options = {}, FootLockReport* report = nullptr);

}  // namespace ugoki::motion_edit
