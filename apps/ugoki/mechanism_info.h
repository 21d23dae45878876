#pragma once
// Information about a mechanism for `ugoki info`.

#include "output.h"
#include "ugoki/mechanism/mechanism.h"
#include "ugoki/robot_formats/robot_model.h"

namespace ugoki::cli {

/// Counts, mass, joints by type, loops, and findings about loops and inertias.
/// @param robot the description (URDF, SDF, MJCF) that the mechanism was read from, for joint names; may be null
[[nodiscard]] Json mechanism_json(const Mechanism& m, const robot_formats::RobotModel* robot = nullptr);

}  // namespace ugoki::cli
