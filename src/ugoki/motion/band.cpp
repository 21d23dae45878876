#include "ugoki/motion/band.h"

namespace ugoki {

void BandLeastSquares::add(std::size_t first, const std::array<double, 3>& c, double value, double weight) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (c[i] == 0) continue;
    right_[first + i] += weight * c[i] * value;
    for (std::size_t j = i; j < 3; ++j) rows_[first + i][j - i] += weight * c[i] * c[j];
  }
}

std::vector<double> BandLeastSquares::solve() const {
  const std::size_t n = rows_.size();
  std::vector<std::array<double, 3>> a = rows_;  // becomes L^T of A = L D L^T; a[i][0] is D
  std::vector<double> x = right_;
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 1; k < 3 && i + k < n; ++k) {
      const double factor = a[i][k] / a[i][0];
      for (std::size_t j = k; j < 3; ++j) a[i + k][j - k] -= factor * a[i][j];
      x[i + k] -= factor * x[i];
    }
  }
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t k = 1; k < 3 && i + k < n; ++k) x[i] -= a[i][k] * x[i + k];
    x[i] /= a[i][0];
  }
  return x;
}

}  // namespace ugoki
