#pragma once
// JSON of mechanisms and motions for the web page, which lists and draws them.

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/content/mechanism_display.h"
#include "ugoki/mechanism/mechanism.h"
#include "ugoki/motion/markers.h"
#include "ugoki/motion/motion.h"

namespace ugoki::studio {

/// JSON of the poses of all links for an animated preview: the answer of GET /api/motion/ID. Contains at most 480 frames, evenly
/// spaced. The motion must fit the mechanism (check_motion).
[[nodiscard]] std::string motion_json(std::string_view id, const Motion& motion, const Mechanism& mechanism);

/// JSON of the marker positions for a preview, at the same frames as motion_json; NaN where a marker was not seen.
[[nodiscard]] std::string markers_json(const MarkerMotion& markers);

using content::mechanism_json;
using content::pose_json;
using content::shown_height;

/// Small curve for a motion in a list: the coordinate with the largest variance, scaled to 0 ... 1, as at most 48 values evenly spaced in
/// time. Root coordinates are used only if the mechanism has no others. Empty if nothing moves or the motion does not fit the mechanism.
[[nodiscard]] std::vector<double> thumbnail_curve(const Motion& motion, const Mechanism& mechanism);

}  // namespace ugoki::studio
