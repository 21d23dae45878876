#pragma once
// What `ugoki info` tells of the meshes and height fields of a mechanism.

#include "output.h"
#include "ugoki/mechanism/mechanism.h"
#include "ugoki/robot_formats/robot_model.h"

namespace ugoki::cli {

/// For each geometry, by its hash: triangles, hull, spheres by depth with their overlap, the time that preparing it takes on this machine,
/// and what is wrong with it. Null where no shape is a mesh. O(preparing all of them)
/// @param robot the description that it was read from: names of files, and what was mended; may be null
[[nodiscard]] Json meshes_json(const Mechanism& m, const robot_formats::RobotModel* robot);

/// The same for height fields.
[[nodiscard]] Json height_fields_json(const Mechanism& m);

}  // namespace ugoki::cli
