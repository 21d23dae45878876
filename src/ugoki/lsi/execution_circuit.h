#pragma once
// The default execution circuit, used by a content without a circuit of its own.

#include <string>
#include <vector>

#include "ugoki/circuit/circuit.h"

namespace ugoki::lsi {

struct CircuitCharacter {
  std::string id;
  bool follows_track = false;                            ///< false: the character moves passively
  double tracking = 1, balance = 1, assist_limit = 0.5;  ///< parameters of its motion control LSI
};

/// Makes the execution circuit. It contains event, collision analysis, dynamics, status and display, and for each character that follows a
/// track: motion retrieval, interpolation, motion control and naturalness; balance control and naturalness if its assist limit is 0. Its input `live` receives the user's events; its outputs are
/// `state`, `contacts`, `events`, `poses`, `characters` and `measures`.
/// @param step  time between ticks, s. Naturalness is measured about 120 times a second, after each whole number of ticks
[[nodiscard]] circuit::Circuit make_execution_circuit(const std::vector<CircuitCharacter>& characters, double step);

}  // namespace ugoki::lsi
