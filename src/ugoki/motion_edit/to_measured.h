#pragma once
// A motion of a mechanism as measured data, for the formats that hold skeletons (BVH, AMC, glTF).

#include "ugoki/motion/motion.h"
#include "ugoki/motion/skeleton.h"

namespace ugoki::motion_edit {

/// The motion with the mechanism's links as joints: frames parallel to the world's in the neutral position, end sites at the far ends of
/// the shapes of outermost links. Every joint is where its link is. What has no meaning for a skeleton (masses, shapes) stays behind. The
/// motion must fit the mechanism.
[[nodiscard]] MeasuredMotion to_measured(const Mechanism& mechanism, const Motion& motion);

}  // namespace ugoki::motion_edit
