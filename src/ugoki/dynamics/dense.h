#pragma once
// Small dense linear algebra for the closed-link reference method. Matrices are stored row by row. Nothing allocates after resize().

#include <span>
#include <vector>

namespace ugoki::dynamics {

/// Rank-revealing Gaussian elimination with full pivoting. Finds independent rows of A, and the columns of the unknowns that these rows
/// determine.
/// A pivot is accepted if its magnitude exceeds `tolerance` times the maximum magnitude in A. Pivots decrease roughly like singular values.
/// @param A [rows.size() * columns.size()] overwritten
/// @param max_rank upper limit of the rank
/// @param rows, columns [out] indices; the first `rank` belong to the pivots, the rest follow in ascending order
/// @return rank. O(rows columns rank)
int choose_pivots(std::span<double> A, double tolerance, int max_rank, std::span<int> rows, std::span<int> columns);

/// LU factorization of a square matrix with partial (row) pivoting.
class LuFactor {
 public:
  void resize(int n);                            ///< allocates for matrices up to n x n
  [[nodiscard]] std::span<double> begin(int n);  ///< [n * n] storage of A, to be filled by the caller; n at most that of resize()
  /// Factors the matrix in place. @return smallest pivot divided by the largest, in magnitude; 0 if the matrix is singular. O(n^3)
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

/// Cholesky factorization A = L L^T of a symmetric positive-definite matrix, in place in the lower triangle. @param A [n * n]
/// @return false if the square of a diagonal entry of L is not above `tolerance` times the diagonal entry of A. O(n^3)
[[nodiscard]] bool factor_cholesky(std::span<double> A, int n, double tolerance);
/// x <- (L L^T)^-1 x
void solve_cholesky(std::span<const double> L, int n, std::span<double> x);

}  // namespace ugoki::dynamics
