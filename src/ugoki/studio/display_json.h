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

/// Links with shapes for display: the answer of GET /api/mechanism/ID.
/// @param q [nq] the position that is shown as neutral; empty: the neutral one
[[nodiscard]] std::string mechanism_json(std::string_view id, const Mechanism& mechanism, std::span<const double> q = {});

/// Poses of all links for a moving preview: the answer of GET /api/motion/ID. At most 480 of its frames, evenly spread.
/// The motion must fit the mechanism (check_motion).
[[nodiscard]] std::string motion_json(std::string_view id, const Motion& motion, const Mechanism& mechanism);

/// Places of markers for a preview, frames as in motion_json; NaN where a marker was not seen.
[[nodiscard]] std::string markers_json(const MarkerMotion& markers);

/// x, y, z, qw, qx, qy, qz
[[nodiscard]] std::vector<double> pose_json(const Pose& X);

/// From the lowest to the highest point of the visible shapes in the neutral position, m; 0 without shapes.
[[nodiscard]] double shown_height(const Mechanism& mechanism);

/// At most 48 numbers between 0 and 1: the coordinate that moves most, over the motion's time. The root's travel does not
/// count where anything else moves. Empty if nothing does.
[[nodiscard]] std::vector<double> thumbnail_curve(const Motion& motion, const Mechanism& mechanism);

}  // namespace ugoki::studio
