#pragma once
// The static schedule of a flat circuit: sizes of all payloads, and the order in which steps run.

#include <memory>
#include <vector>

#include "ugoki/circuit/flatten.h"
#include "ugoki/circuit/setup.h"

namespace ugoki::circuit {

struct Plan {
  std::vector<Setup> setups;             ///< [lsis] with parameters, sizes and resources
  std::vector<int> order;                ///< of `step`: producers before consumers; by depth (wires from a source), then by id
  std::vector<std::uint32_t> wave_ends;  ///< ends in `order` of the LSIs of equal depth, which do not depend on each other
};

/// Sizes every payload and orders the steps. Refused, with all names: sizes that nothing decides, wires between different subjects or
/// sizes, circles of feed-through outputs and direct inputs.
[[nodiscard]] Plan make_plan(const FlatCircuit& flat, const Resources* resources, double dt, Error& problems);

}  // namespace ugoki::circuit
