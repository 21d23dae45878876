#pragma once
// Frames of a calibration pose before a motion. Internal to body.

#include "ugoki/motion/skeleton.h"

namespace ugoki::body {

/// The motion without its first `count` frames.
[[nodiscard]] MeasuredMotion without_first(const MeasuredMotion& motion, int count);

}  // namespace ugoki::body
