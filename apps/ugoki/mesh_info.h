#pragma once
// Information about the meshes and height fields of a mechanism for `ugoki info`.

#include "output.h"
#include "ugoki/mechanism/mechanism.h"
#include "ugoki/robot_formats/robot_model.h"

namespace ugoki::cli {

/// One row for each geometry: hash, triangles, hull, size and overlap of the sphere tree at each depth, preparation time on this machine,
/// and problems. Null: no shape is a mesh. Slow, because it prepares all geometries.
/// @param robot the description that the mechanism was read from, for names of files and repairs; may be null
[[nodiscard]] Json meshes_json(const Mechanism& m, const robot_formats::RobotModel* robot);

/// Information about the height fields; null: there is none.
[[nodiscard]] Json height_fields_json(const Mechanism& m);

}  // namespace ugoki::cli
