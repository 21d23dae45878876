#pragma once
// Smoothing of a sequence whose values have weights.

#include <span>
#include <vector>

namespace ugoki {

/// Returns the x that minimises sum weight[i] (x[i] - value[i])^2 + stiffness (x[i + 1] - x[i])^2. x follows the values of nonzero
/// weight, is linear between these values, and constant before the first and after the last of them. All zero if no weight is
/// above 1e-3. O(values)
[[nodiscard]] std::vector<double> pass_through(std::span<const double> value, std::span<const double> weight, double stiffness);

}  // namespace ugoki
