#pragma once
// Real content as a simulation: the player of executable data.

#include "ugoki/studio/simulation.h"

namespace ugoki::studio {

/// Opens executable data (*.ugx).
[[nodiscard]] Result<std::unique_ptr<Simulation>> open_player(std::span<const std::byte> executable);

}  // namespace ugoki::studio
