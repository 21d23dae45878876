#pragma once
// Measured feet that stand a little too high or too low, brought onto the floor.

#include "ugoki/motion/motion.h"

namespace ugoki {

/// The motion with standing feet on the floor. Measured soles are off by millimetres to centimetres, differently for each foot and
/// step; a body of rigid shapes that follows them lands early on one foot and late on the other. While a foot bears on the ground
/// (label_contacts), its lowest point is brought to z = `floor`; between, the correction changes evenly; no foot is left below the floor.
/// What both feet have in common moves the root, within 0.1 s; the rest is done by the joints between the foot and the next link that
/// it shares with another foot, with the foot's orientation kept, by damped least squares (Buss 2009). Only for a floating root.
/// @param floor m
[[nodiscard]] Motion with_feet_on_floor(const Motion& motion, const Mechanism& mechanism, double floor);

}  // namespace ugoki
