#pragma once
// Reads single <joint>, <geom> and <site> elements of MJCF. Internal to robot_formats.

#include "ugoki/robot_formats/mjcf_tree.h"

namespace ugoki::robot_formats {

/// Reads a joint.
/// @param a the element with its defaults; for a <freejoint> the element alone
/// @param X_BF the frame in which the element is written, in the body's frame
[[nodiscard]] MjcfJoint read_mjcf_joint(const MjcfSource& source, const MjcfAttributes& a, const Pose& X_BF);

/// Reads a geom. X_BF: as for a joint.
[[nodiscard]] MjcfGeom read_mjcf_geom(const MjcfSource& source, const MjcfAttributes& a, const Pose& X_BF);

/// Position and orientation of a geom or site. If the element has `fromto`, the ends determine the pose, and their half distance [m] is
/// stored in `size`.
[[nodiscard]] Pose read_mjcf_placement(const MjcfSource& source, const MjcfAttributes& a, MjcfGeomType type, Vec3& size);

/// Whether a range attribute is in force: as the attribute `limited` states; if that is absent or "auto", whether a range is given.
[[nodiscard]] bool mjcf_limited(const MjcfCompiler& compiler, const MjcfAttributes& a, const char* limited, const char* range);

}  // namespace ugoki::robot_formats
