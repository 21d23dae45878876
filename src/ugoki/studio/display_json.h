#pragma once
// Mechanisms and motions as the page lists and draws them.

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/mechanism/mechanism.h"
#include "ugoki/motion/markers.h"
#include "ugoki/motion/motion.h"

namespace ugoki::studio {

/// JSON of a mechanism's links with their visible shapes: the answer of GET /api/mechanism/ID.
/// @param q [nq] position that the poses in "neutral" show; empty: the mechanism's neutral position
[[nodiscard]] std::string mechanism_json(std::string_view id, const Mechanism& mechanism, std::span<const double> q = {});

/// JSON of the poses of all links for an animated preview: the answer of GET /api/motion/ID. Contains at most 480 frames, evenly
/// spaced. The motion must fit the mechanism (check_motion).
[[nodiscard]] std::string motion_json(std::string_view id, const Motion& motion, const Mechanism& mechanism);

/// JSON of the marker positions for a preview, at the same frames as motion_json; NaN where a marker was not seen.
[[nodiscard]] std::string markers_json(const MarkerMotion& markers);

/// The pose as [x, y, z, qw, qx, qy, qz], m and unit quaternion.
[[nodiscard]] std::vector<double> pose_json(const Pose& X);

/// Height of the visible shapes in the neutral position, from the lowest to the highest point, m; 0 without shapes.
[[nodiscard]] double shown_height(const Mechanism& mechanism);

/// Small curve for a motion's list entry: at most 48 values from 0 to 1 of the coordinate with the largest variance, evenly spaced in
/// time. Root coordinates are used only if the mechanism has no others. Empty if nothing moves or the motion does not fit.
[[nodiscard]] std::vector<double> thumbnail_curve(const Motion& motion, const Mechanism& mechanism);

}  // namespace ugoki::studio
