#pragma once
// Main function of the interpreter's process. It inherits four open file descriptors from the studio: the control socket, the memory of
// the frame ring, an eventfd that signals new frames, and a pipe for last words (the fault report of a crashing process).

#include "ugoki/studio/simulation.h"

namespace ugoki::studio {

/// File descriptors in the interpreter's process.
namespace child_file {
inline constexpr int control = 3, frames = 4, signal = 5;
inline constexpr int words = 6;  ///< pipe for last words (plugin/guard.h)
}  // namespace child_file

/// Serves requests until the studio closes the control socket, then ends the process. @return exit status if it cannot start
int run_interpreter(SimulationOpener opener);

}  // namespace ugoki::studio
