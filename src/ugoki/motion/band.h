#pragma once
// Least squares with a symmetric band matrix.

#include <array>
#include <vector>

namespace ugoki {

/// Sum of squares of linear terms, each of up to three neighbouring unknowns, and its minimum. O(unknowns)
class BandLeastSquares {
 public:
  explicit BandLeastSquares(std::size_t unknowns) : rows_(unknowns, std::array<double, 3>{}), right_(unknowns, 0.0) {}

  /// Adds weight * (c[0] x[first] + c[1] x[first + 1] + c[2] x[first + 2] - value)^2. Coefficients beyond the last unknown must be zero.
  void add(std::size_t first, const std::array<double, 3>& c, double value, double weight);
  /// Adds weight * (x[i] - value)^2.
  void add(std::size_t i, double value, double weight) { add(i, {1, 0, 0}, value, weight); }
  /// Returns the unknowns of the minimum. The terms must determine every unknown.
  [[nodiscard]] std::vector<double> solve() const;

 private:
  std::vector<std::array<double, 3>> rows_;  // upper half of the normal matrix: diagonal and two entries to its right
  std::vector<double> right_;
};

}  // namespace ugoki
