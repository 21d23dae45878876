#pragma once
// Reads single <joint>, <geom> and <site> elements of MJCF. Internal to robot_formats.

#include "ugoki/robot_formats/mjcf_tree.h"

namespace ugoki::robot_formats {

/// Reads a joint element.
/// @param a the element with its defaults; for a <freejoint> the element without defaults
/// @param X_BF pose, in the body's frame, of the frame to which the element's coordinates refer
[[nodiscard]] MjcfJoint read_mjcf_joint(const MjcfSource& source, const MjcfAttributes& a, const Pose& X_BF);

/// Reads a geom element. @param X_BF as for read_mjcf_joint()
[[nodiscard]] MjcfGeom read_mjcf_geom(const MjcfSource& source, const MjcfAttributes& a, const Pose& X_BF);

/// Reads the pose of a geom or site in the frame to which its coordinates refer. If the element has `fromto`, its two points determine the
/// pose, and half the distance between them [m] is stored in `size`.
[[nodiscard]] Pose read_mjcf_placement(const MjcfSource& source, const MjcfAttributes& a, MjcfGeomType type, Vec3& size);

/// True if the attribute `range` applies. The attribute `limited` decides. If `limited` is absent or "auto", a range applies if it is
/// present, is not "0 0", and the compiler's autolimits is true.
[[nodiscard]] bool mjcf_limited(const MjcfCompiler& compiler, const MjcfAttributes& a, const char* limited, const char* range);

}  // namespace ugoki::robot_formats
