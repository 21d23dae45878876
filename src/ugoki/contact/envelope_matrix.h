#pragma once
// Sparse matrix, symmetric and positive definite or of symmetric structure, stored as an envelope: in each row the entries from the first
// nonzero column to the diagonal. Factoring fills in entries only inside the envelope. Source: George, Liu (1981), Computer solution of
// large sparse positive definite systems, chapter 4.

#include <algorithm>
#include <cstddef>
#include <vector>

#include "ugoki/contact/solver_kernels.h"

namespace ugoki::contact {

class EnvelopeMatrix {
 public:
  /// Reserves memory for n rows with `entries` stored entries in total.
  void reserve(std::size_t n, std::size_t entries);

  // To define the envelope: begin(n), then include() for each row and column that may be nonzero, then finish().
  void begin(int n);
  /// Extends the row's envelope to this column. @param column at most `row`
  void include(int row, int column) {
    int& first = first_[static_cast<std::size_t>(row)];
    first = std::min(first, column);
  }
  /// Sets the locations of the rows. @return estimated number of floating-point operations of factor()
  double finish();
  /// Reserves the entries of the present envelope. Their values are undefined until set_identity().
  void allocate() { values_.resize(size_); }

  [[nodiscard]] std::size_t rows() const { return first_.size(); }
  /// Row of the lower triangle: entry (row, column) is row_data(row)[column], for columns from the first nonzero one to `row`.
  [[nodiscard]] double* row_data(int row) {
    const auto i = static_cast<std::size_t>(row);
    return values_.data() + start_[i] - first_[i];
  }
  void set_identity();
  /// Makes the matrix unsymmetric: sets its upper triangle to zero.
  void set_upper_identity() { upper_.assign(size_, 0.0); }
  /// The matrix for solver_kernels(); valid until the next call of begin().
  [[nodiscard]] EnvelopeArguments arguments() {
    return {static_cast<int>(first_.size()), first_.data(), start_.data(), values_.data(), upper_.data()};
  }

  /// Solves A x = b and replaces the matrix by its Cholesky factor with inverted diagonal. A must be positive definite.
  /// @param b [n] @param x [n, out]
  void solve(const std::vector<double>& b, std::vector<double>& x);
  /// Solves A x = b and replaces the matrix by its factors L U. No rows are exchanged. @param b [n] @param x [n, out]
  void solve_unsymmetric(const std::vector<double>& b, std::vector<double>& x);

 private:
  std::vector<int> first_;          // [n] first column of each row
  std::vector<std::size_t> start_;  // [n] index in values_ of the first entry of each row
  std::vector<double> values_;
  std::vector<double> upper_;  // like values_, for the transposed upper triangle of an unsymmetric matrix
  std::size_t size_ = 0;       // number of entries
};

}  // namespace ugoki::contact
