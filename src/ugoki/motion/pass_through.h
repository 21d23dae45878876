#pragma once
// A smooth row of numbers through those that count.

#include <span>
#include <vector>

namespace ugoki {

/// x of least sum of weight (x - value)^2 + stiffness (x[i + 1] - x[i])^2: follows the values where they have weight, runs straight
/// between, and level before the first and after the last. All zero without any weight. O(values)
[[nodiscard]] std::vector<double> pass_through(std::span<const double> value, std::span<const double> weight, double stiffness);

}  // namespace ugoki
