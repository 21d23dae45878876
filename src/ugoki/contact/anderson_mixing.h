#pragma once
// Acceleration of a fixed-point iteration x <- g(x) that converges slowly along a few directions.
//
// With the residuals f_k = g(x_k) - x_k of the last iterations, the next estimate is
//   x_k + f_k - (dX + dF) c,   c = argmin |f_k - dF c|
// where the columns of dX and dF are the differences of successive estimates and residuals. For a linear g, this is GMRES.
// The history is discarded when the residual grows, because g then changed its active set.
// Source: Anderson (1965), Iterative procedures for nonlinear integral equations; Walker, Ni (2011), SIAM J. Numer. Anal. 49(4).

#include <cstddef>
#include <span>
#include <vector>

namespace ugoki::contact {

class AndersonMixing {
 public:
  static constexpr std::size_t max_columns = 5;

  /// Begins an iteration with `size` unknowns. Allocates only if no earlier iteration had as many.
  void begin(std::size_t size);
  /// Replaces x by the next estimate. @param x [size] present estimate @param g [size] value of the map at x; all unknowns have one unit
  void next(std::span<double> x, std::span<const double> g);

 private:
  [[nodiscard]] std::span<double> column(std::vector<double>& of, std::size_t k);

  std::size_t size_ = 0, columns_ = 0, newest_ = 0;
  bool has_last_ = false;
  double last_square_ = 0;               // |f|^2 of the last call
  std::vector<double> last_x_, last_f_;  // [size]
  std::vector<double> dX_, dF_;          // [max_columns * size]
};

}  // namespace ugoki::contact
