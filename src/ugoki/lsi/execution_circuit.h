#pragma once
// The default execution circuit, for content without a circuit of its own.

#include <string>
#include <vector>

#include "ugoki/circuit/circuit.h"

namespace ugoki::lsi {

struct CircuitCharacter {
  std::string id;
  bool follows_track = false;                            ///< false: the character moves passively
  double tracking = 1, balance = 1, assist_limit = 0.5;  ///< parameters of the character's motion control LSI
  bool has_moves = false;                                ///< true: rules play motions instead of the track (LSI `motion choice`)
  enum class Drive { control, path, torque };
  /// control: motion control, or balance control without assist. path: motion control with high gains and assist. torque: motion torques
  Drive drive = Drive::control;
  double swing = 0;    ///< deg: parameter of balance control
  bool grips = false;  ///< the content has grips, which balance control has to know
};

/// Makes the execution circuit from LSIs (function blocks). Its outermost level contains event, collision analysis, dynamics, status and
/// display, and for each character that follows a track one nested circuit "character ID". The nested circuit contains motion retrieval (or
/// motion choice, if rules play motions), interpolation, motion control and naturalness; if the character's assist limit is 0, only balance
/// control and naturalness. Drive::torque replaces motion control by the LSI `motion torques`. Balance control gets the grips of the last
/// tick (LSI `delay event`) if the content has any. The input `live` receives the user's events. The outputs are `state`, `contacts`,
/// `events`, `poses`, `characters` and `measures`.
/// @param step  s, time between ticks. Naturalness is measured about 120 times a second, always after the same number of ticks
[[nodiscard]] circuit::Circuit make_execution_circuit(const std::vector<CircuitCharacter>& characters, double step);

}  // namespace ugoki::lsi
