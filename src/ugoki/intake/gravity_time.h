#pragma once
// Gives the flights of a hand-animated motion the timing that gravity gives them.

#include <string>

#include "ugoki/mechanism/mechanism.h"
#include "ugoki/motion/motion.h"
#include "ugoki/motion/skeleton.h"

namespace ugoki::intake {

/// Plays `measured` with another timing if it contains flights that do not suit gravity (flight_timing.h). Poses and paths stay; if the
/// timing alone is not sufficient, the roots are also raised or lowered in the flights. Unchanged are flights during which the character
/// travels fast (a gallop), motions without wrong flights, and those in which 80 % of the impossible acceleration cannot be removed.
/// @param motion the same motion of the body  @param height m, of the character
/// @return a sentence about the change; empty without a change
std::string retime_to_gravity(MeasuredMotion& measured, const Mechanism& mechanism, const Motion& motion, double height);

}  // namespace ugoki::intake
