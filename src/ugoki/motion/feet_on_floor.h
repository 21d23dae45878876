#pragma once
// Corrects measured feet that stand slightly above or below the floor.

#include "ugoki/motion/motion.h"

namespace ugoki {

/// Returns the motion with its standing feet on the floor. The height of measured soles is wrong by millimetres to centimetres, differently
/// for each foot and step. A rigid body that follows these soles lands too early on one foot and too late on the other. While a foot is in
/// contact (label_contacts), its lowest point is moved to z = `floor`. Between contacts the correction is interpolated. No foot stays below
/// the floor. The common correction of the standing feet moves the root, smoothed over 0.1 s. Inverse kinematics (damped least squares,
/// Buss 2009) of the joints that move only one foot applies the foot's remaining correction and keeps the foot's orientation. The motion is
/// returned unchanged if the root is not floating or there are no feet.
/// @param floor m, height of the floor
[[nodiscard]] Motion with_feet_on_floor(const Motion& motion, const Mechanism& mechanism, double floor);

}  // namespace ugoki
