#pragma once
// The execution circuit that content runs on when it brings none of its own: data like any other circuit.

#include <string>
#include <vector>

#include "ugoki/circuit/circuit.h"

namespace ugoki::lsi {

struct CircuitCharacter {
  std::string id;
  bool follows_track = false;  ///< false: it moves passively
  double tracking = 1, balance = 1, assist_limit = 0.5;
};

/// events -> for each character that follows a track: motion retrieval, interpolation, motion control, naturalness -> collision
/// analysis -> dynamics -> status -> display. Its input `live` takes the user's events; its outputs are `state`, `contacts`,
/// `events`, `poses`, `figures` and `measures`.
/// @param step s, between ticks: decides how often naturalness is measured
[[nodiscard]] circuit::Circuit make_execution_circuit(const std::vector<CircuitCharacter>& characters, double step);

}  // namespace ugoki::lsi
