#pragma once
// Scene of the contact benchmarks: a human-like character of 22 links and 45 DOFs.

#include "ugoki/mechanism/mechanism.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::benchmarks {

/// The mechanism: floating pelvis; spine, neck and head; arms and legs with ball joints and hinges; feet with toes. Boxes of 1000 kg/m^3.
MechanismPtr make_character();

/// A deterministic state in which every joint is bent and every DOF moves and is driven.
State lively_state(const Mechanism& character);

/// A state standing upright at rest, soles on z = 0.
State standing_state(const Mechanism& character);

}  // namespace ugoki::benchmarks
