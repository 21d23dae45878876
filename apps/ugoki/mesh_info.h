#pragma once
// Information about the meshes and height fields of a mechanism for `ugoki info`.

#include "output.h"
#include "ugoki/mechanism/mechanism.h"
#include "ugoki/robot_formats/robot_model.h"

namespace ugoki::cli {

/// For each geometry, by its hash: triangles, hull, sphere tree by depth with overlaps, preparation time on this machine, and problems.
/// Null: no shape is a mesh. Takes the time of preparing all geometries.
/// @param robot the description that the mechanism was read from, for names of files and repairs; may be null
[[nodiscard]] Json meshes_json(const Mechanism& m, const robot_formats::RobotModel* robot);

/// Information about the height fields; null: there is none.
[[nodiscard]] Json height_fields_json(const Mechanism& m);

}  // namespace ugoki::cli
