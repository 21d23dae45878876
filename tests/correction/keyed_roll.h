#pragma once
// A forward roll made by hand as keys: from standing over hands and shoulders to a seat. The keys ignore dynamics.

#include "ugoki/mechanism/mechanism.h"
#include "ugoki/motion/motion.h"

namespace ugoki::correction {

/// The roll of samples::make_person(), 60 frames a second.
[[nodiscard]] Motion keyed_roll(const Mechanism& person);

}  // namespace ugoki::correction
