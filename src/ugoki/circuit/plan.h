#pragma once
// Static schedule of a flat circuit: the sizes of all payloads and the order of the steps.

#include <memory>
#include <vector>

#include "ugoki/circuit/flatten.h"
#include "ugoki/circuit/setup.h"

namespace ugoki::circuit {

struct Plan {
  std::vector<Setup> setups;  ///< by index of the LSI: parameters, sizes and resources of the LSI
  /// Indices of LSIs in the order in which their steps run: producers before consumers, sorted by depth, then by id. The depth of an LSI is
  /// the length of the longest chain of feed-through wires that ends at it.
  std::vector<int> order;
  std::vector<std::uint32_t> wave_ends;  ///< for each depth: end index in `order`; LSIs of one depth are independent
};

/// Sizes every payload and orders the steps. Reports undefined sizes, wires between pins of different size or subject (Shape, setup.h), and
/// algebraic loops (cycles of feed-through outputs and direct inputs). Each report names the LSIs and pins.
[[nodiscard]] Plan make_plan(const FlatCircuit& flat, const Resources* resources, double dt, Error& problems);

}  // namespace ugoki::circuit
