#pragma once
// The interpreter's process. Its control socket, frame ring, frame signal and a pipe for last words are handed down as open files.

#include "ugoki/studio/simulation.h"

namespace ugoki::studio {

namespace child_file {
inline constexpr int control = 3, frames = 4, signal = 5;
inline constexpr int words = 6;  ///< last words (plugin/guard.h)
}  // namespace child_file

/// Serves until the studio closes the control socket. @return exit status
int run_interpreter(SimulationOpener opener);

}  // namespace ugoki::studio
