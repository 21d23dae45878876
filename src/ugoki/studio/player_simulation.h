#pragma once
// Implements the interface Simulation with content::Player, which runs executable data.

#include "ugoki/studio/simulation.h"

namespace ugoki::plugin {
class LiveLibrary;
}

namespace ugoki::studio {

/// All LSIs that content may use: built-in and installed. Loads the code of installed libraries, so call it in the interpreter's
/// process only.
[[nodiscard]] plugin::LiveLibrary& lsi_library();

/// Opens executable data (*.ugx).
[[nodiscard]] Result<std::unique_ptr<Simulation>> open_player(std::span<const std::byte> executable);

}  // namespace ugoki::studio
