#pragma once
// Small dense linear algebra of the closed-link reference. Matrices are row by row; nothing allocates after resize().

#include <span>
#include <vector>

namespace ugoki::dynamics {

/// Rank-revealing elimination with full pivoting: which rows of A are independent, and which columns they are solved for.
/// A pivot counts as long as it exceeds `tolerance` times the greatest entry of A; pivots fall roughly like singular values.
/// @param A [rows.size() * columns.size()] destroyed
/// @param rows, columns [out] indices; the first `rank` belong to the pivots, the rest follow in rising order
/// @param most the rank is not taken to be greater
/// @return rank. O(rows columns rank)
int choose_pivots(std::span<double> A, double tolerance, int most, std::span<int> rows, std::span<int> columns);

/// Factors of a square matrix with row exchanges.
class LuFactor {
 public:
  void resize(int n);                            ///< room for n x n
  [[nodiscard]] std::span<double> begin(int n);  ///< [n * n] to be filled, n at most the room
  /// @return the smallest pivot's part of the greatest one; 0 where the matrix is singular. O(n^3)
  [[nodiscard]] double factor();
  void solve(std::span<double> x) const;             ///< x <- A^-1 x
  void solve_transposed(std::span<double> x) const;  ///< x <- A^-T x
  /// X <- A^-1 X for `count` right-hand sides. @param X [n * count], one row for each unknown
  void solve_many(std::span<double> X, int count) const;

 private:
  int n_ = 0;
  std::vector<double> lu_;
  std::vector<int> exchange_;
};

/// A = L L^T of a symmetric positive-definite matrix, in place (lower triangle). @param A [n * n]
/// @return false where a pivot is not above `tolerance` times its diagonal entry. O(n^3)
[[nodiscard]] bool factor_cholesky(std::span<double> A, int n, double tolerance);
/// x <- (L L^T)^-1 x
void solve_cholesky(std::span<const double> L, int n, std::span<double> x);

}  // namespace ugoki::dynamics
