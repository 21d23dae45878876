#pragma once
// Motions of bodies. Internal to body.

#include "ugoki/body/body.h"

namespace ugoki::body {

// In each of these functions the measured motion is in the body's rest pose.

[[nodiscard]] Pose floor_pose_at_rest(const Body& body, const MeasuredMotion& motion);
[[nodiscard]] Motion convert(const Body& body, const MeasuredMotion& m);
/// @return largest distance between a joint of the motion and that of the body, m
[[nodiscard]] double position_error(const Body& body, const MeasuredMotion& measured, const Motion& motion);

}  // namespace ugoki::body
