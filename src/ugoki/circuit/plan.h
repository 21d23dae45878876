#pragma once
// Static schedule of a flat circuit: the sizes of all payloads and the order of the steps.

#include <memory>
#include <vector>

#include "ugoki/circuit/flatten.h"
#include "ugoki/circuit/setup.h"

namespace ugoki::circuit {

struct Plan {
  std::vector<Setup> setups;  ///< [lsis] parameters, sizes and resources of each LSI
  /// Indices of LSIs in the order in which their steps run: producers before consumers, sorted by depth, then by id. The depth of an LSI is
  /// the length of the longest chain of feed-through wires that ends at it.
  std::vector<int> order;
  std::vector<std::uint32_t> wave_ends;  ///< [depths] end index in `order` of each depth; LSIs of one depth are independent
};

/// Sizes every payload and orders the steps. Reports undefined sizes, wires between pins of different size or subject, and algebraic loops
/// (cycles of feed-through outputs and direct inputs). Each report names the LSIs and pins.
[[nodiscard]] Plan make_plan(const FlatCircuit& flat, const Resources* resources, double dt, Error& problems);

}  // namespace ugoki::circuit
