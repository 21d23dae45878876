#pragma once
// Converts a motion of a mechanism to measured data, for file formats with skeletons (BVH, AMC, glTF).

#include "ugoki/motion/motion.h"
#include "ugoki/motion/skeleton.h"

namespace ugoki::motion_edit {

/// Converts the motion to a skeleton with one joint per link, at the origin of the link's frame. In the neutral position all joint frames
/// are parallel to the world's. Links without children get end sites at the far ends of their shapes. Link masses and shapes are dropped.
/// The motion must fit the mechanism (check_motion).
[[nodiscard]] MeasuredMotion to_measured(const Mechanism& mechanism, const Motion& motion);

}  // namespace ugoki::motion_edit
