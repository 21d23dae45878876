#pragma once
// Corrects measured feet that stand slightly above or below the floor.

#include "ugoki/motion/motion.h"

namespace ugoki {

/// Returns the motion with its standing feet on the floor. Measured soles are off by millimetres to centimetres, differently for each foot
/// and step; a rigid body that follows them lands too early on one foot and too late on the other.
/// While a foot is in contact (label_contacts), its lowest point is moved to z = `floor`; between contacts the correction is interpolated;
/// no foot stays below the floor. The correction common to the standing feet moves the root, smoothed over 0.1 s. The remainder is done by
/// inverse kinematics (damped least squares, Buss 2009) of the joints that move only this foot; the foot's orientation is kept.
/// The motion is returned unchanged if the root is not floating or there are no feet.
/// @param floor m, height of the floor
[[nodiscard]] Motion with_feet_on_floor(const Motion& motion, const Mechanism& mechanism, double floor);

}  // namespace ugoki
