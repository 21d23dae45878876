#pragma once
// Real content as a simulation: the player of executable data.

#include "ugoki/studio/simulation.h"

namespace ugoki::plugin {
class LiveLibrary;
}

namespace ugoki::studio {

/// All LSIs that content may use here: the program's and the installed ones. Loads foreign code: in the interpreter's process only.
[[nodiscard]] plugin::LiveLibrary& lsi_library();

/// Opens executable data (*.ugx).
[[nodiscard]] Result<std::unique_ptr<Simulation>> open_player(std::span<const std::byte> executable);

}  // namespace ugoki::studio
