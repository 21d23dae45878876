#pragma once
// Synthetic creatures: random trees with legs, tails, wings and necks, and a small motion.

#include <cstdint>

#include "ugoki/motion/skeleton.h"

namespace ugoki::dialects {

/// A creature with a trunk of one to four joints, 2 to 12 legs of two to four bones, and sometimes tail, neck, wings and end bones. Its
/// size is 2 cm to 6 m. It sways on its feet for two seconds. Equal seeds give equal creatures.
[[nodiscard]] MeasuredMotion make_creature(std::uint64_t seed);

}  // namespace ugoki::dialects
