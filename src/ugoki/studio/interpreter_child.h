#pragma once
// Main function of the interpreter's process. The process inherits five open file descriptors from the studio: the control socket, the
// memory of the frame ring, an eventfd that signals new frames, a pipe for the fault report of a crash ("last words"), and memory in
// which the child records the LSI that is running (plugin/guard_block.h).

#include "ugoki/studio/simulation.h"

namespace ugoki::studio {

/// File descriptors in the interpreter's process.
namespace child_file {
inline constexpr int control = 3, frames = 4, signal = 5;
inline constexpr int words = 6;  ///< pipe for the fault report of a crash (plugin/guard.h)
inline constexpr int guard = 7;  ///< memory of the guard block (plugin/guard_block.h)
}  // namespace child_file

/// Serves requests until the studio closes the control socket, then ends the process. @return exit status if serving cannot start
int run_interpreter(SimulationOpener opener);

}  // namespace ugoki::studio
