#pragma once
// Table of gaits: duty factors, phases of the legs and duration of strides. Internal to gait.

#include <vector>

#include "ugoki/gait/gait.h"

namespace ugoki::gait {

/// Legs in rows from the back to the front.
struct LegPlace {
  int row = 0;  ///< 0: hindmost
  bool left = false;
};

/// Timing of a gait at one speed.
struct Pattern {
  double duty = 0.6;           ///< share of the stride in which a foot stands
  double stride_time = 1;      ///< s
  std::vector<double> phases;  ///< [legs] touch-down as a share of the stride
};

/// Kinds that are known for this number of legs.
[[nodiscard]] std::vector<GaitKind> kinds_for(int legs);

/// @param leg_length m: height of the hips while the character stands @param speed m/s
[[nodiscard]] Pattern pattern_of(GaitKind kind, const std::vector<LegPlace>& legs, double leg_length, double speed, double gravity);

}  // namespace ugoki::gait
