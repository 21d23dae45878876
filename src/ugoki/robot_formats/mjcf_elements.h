#pragma once
// Single <joint> and <geom> elements of MJCF. Internal to robot_formats.

#include "ugoki/robot_formats/mjcf_tree.h"

namespace ugoki::robot_formats {

/// A joint in the frame X_BF of its body. @param a the element over its defaults; of a <freejoint> the element alone
[[nodiscard]] MjcfJoint read_mjcf_joint(const MjcfSource& source, const MjcfAttributes& a, const Pose& X_BF);

/// A geom in the frame X_BF of its body.
[[nodiscard]] MjcfGeom read_mjcf_geom(const MjcfSource& source, const MjcfAttributes& a, const Pose& X_BF);

/// Position and orientation of a geom or site, from its ends if it has `fromto`, whose length then goes into `size`.
[[nodiscard]] Pose read_mjcf_placement(const MjcfSource& source, const MjcfAttributes& a, MjcfGeomType type, Vec3& size);

/// Whether a range holds: `limited` says so, or leaves it (auto) to whether there is one.
[[nodiscard]] bool mjcf_limited(const MjcfCompiler& compiler, const MjcfAttributes& a, const char* limited, const char* range);

}  // namespace ugoki::robot_formats
