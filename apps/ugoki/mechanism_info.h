#pragma once
// What `ugoki info` tells of a mechanism.

#include "output.h"
#include "ugoki/mechanism/mechanism.h"
#include "ugoki/robot_formats/robot_model.h"

namespace ugoki::cli {

/// Counts, mass, joints by type, loops, and what the loops and inertias do to its motion.
/// @param robot the description that it was read from, for the names of joints; may be null
[[nodiscard]] Json mechanism_json(const Mechanism& m, const robot_formats::RobotModel* robot = nullptr);

}  // namespace ugoki::cli
