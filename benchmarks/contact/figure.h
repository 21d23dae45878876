#pragma once
// The scene of these measurements: a figure of 22 links and 45 freedoms, built like a human, in a lively pose.

#include "ugoki/mechanism/mechanism.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::benchmarks {

/// Floating pelvis; spine, neck and head; arms and legs of ball joints and hinges, feet with toes. Boxes of density 1000.
MechanismPtr make_figure();

/// Every joint bent, every freedom moving and driven: the same numbers each time.
State lively_state(const Mechanism& figure);

/// Standing upright, soles on z = 0, at rest.
State standing_state(const Mechanism& figure);

}  // namespace ugoki::benchmarks
