#include "ugoki/dynamics/dense.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "ugoki/base/check.h"

namespace ugoki::dynamics {

int choose_pivots(std::span<double> A, double tolerance, int max_rank, std::span<int> rows, std::span<int> columns) {
  const std::size_t m = rows.size(), n = columns.size();
  UGOKI_CHECK(A.size() == m * n);
  for (std::size_t i = 0; i < m; ++i) rows[i] = static_cast<int>(i);
  for (std::size_t j = 0; j < n; ++j) columns[j] = static_cast<int>(j);
  double threshold = 0;
  std::size_t rank = 0;
  for (const std::size_t end = std::min({m, n, static_cast<std::size_t>(max_rank)}); rank < end; ++rank) {
    std::size_t pivot_row = rank, pivot_column = rank;
    double maximum = 0;
    for (std::size_t i = rank; i < m; ++i)
      for (std::size_t j = rank; j < n; ++j)
        if (const double size = std::fabs(A[i * n + j]); size > maximum) {
          maximum = size;
          pivot_row = i;
          pivot_column = j;
        }
    if (rank == 0) threshold = tolerance * maximum;
    if (!(maximum > threshold)) break;
    if (pivot_row != rank) {
      std::swap_ranges(&A[rank * n], &A[rank * n] + n, &A[pivot_row * n]);
      std::swap(rows[rank], rows[pivot_row]);
    }
    if (pivot_column != rank) {
      for (std::size_t i = 0; i < m; ++i) std::swap(A[i * n + rank], A[i * n + pivot_column]);
      std::swap(columns[rank], columns[pivot_column]);
    }
    const double* top = &A[rank * n];
    for (std::size_t i = rank + 1; i < m; ++i) {
      double* row = &A[i * n];
      const double factor = row[rank] / top[rank];
      if (factor == 0) continue;
      for (std::size_t j = rank; j < n; ++j) row[j] -= factor * top[j];
    }
  }
  const auto first = static_cast<std::ptrdiff_t>(rank);
  std::sort(rows.begin() + first, rows.end());
  std::sort(columns.begin() + first, columns.end());
  return static_cast<int>(rank);
}

void LuFactor::resize(int n) {
  const auto size = static_cast<std::size_t>(n);
  lu_.resize(size * size);
  exchange_.resize(size);
}

std::span<double> LuFactor::begin(int n) {
  UGOKI_CHECK(static_cast<std::size_t>(n) <= exchange_.size());
  n_ = n;
  return std::span(lu_).first(static_cast<std::size_t>(n) * static_cast<std::size_t>(n));
}

double LuFactor::factor() {
  const auto n = static_cast<std::size_t>(n_);
  double minimum = 0, maximum = 0;
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t best = k;
    for (std::size_t i = k + 1; i < n; ++i)
      if (std::fabs(lu_[i * n + k]) > std::fabs(lu_[best * n + k])) best = i;
    const double pivot = lu_[best * n + k];
    if (!(std::fabs(pivot) > 0)) return 0;
    exchange_[k] = static_cast<int>(best);
    if (best != k) std::swap_ranges(&lu_[k * n], &lu_[k * n] + n, &lu_[best * n]);
    minimum = k == 0 ? std::fabs(pivot) : std::min(minimum, std::fabs(pivot));
    maximum = std::max(maximum, std::fabs(pivot));
    const double* top = &lu_[k * n];
    for (std::size_t i = k + 1; i < n; ++i) {
      double* row = &lu_[i * n];
      if (row[k] == 0) continue;
      row[k] /= pivot;
      for (std::size_t j = k + 1; j < n; ++j) row[j] -= row[k] * top[j];
    }
  }
  return n == 0 ? 1 : minimum / maximum;
}

void LuFactor::solve(std::span<double> x) const { solve_many(x, 1); }

void LuFactor::solve_many(std::span<double> X, int count) const {
  const auto n = static_cast<std::size_t>(n_), columns = static_cast<std::size_t>(count);
  for (std::size_t k = 0; k < n; ++k)
    if (const auto other = static_cast<std::size_t>(exchange_[k]); other != k)
      std::swap_ranges(&X[k * columns], &X[k * columns] + columns, &X[other * columns]);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = 0; k < i; ++k)
      if (const double l = lu_[i * n + k]; l != 0)
        for (std::size_t c = 0; c < columns; ++c) X[i * columns + c] -= l * X[k * columns + c];
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t k = i + 1; k < n; ++k)
      if (const double u = lu_[i * n + k]; u != 0)
        for (std::size_t c = 0; c < columns; ++c) X[i * columns + c] -= u * X[k * columns + c];
    for (std::size_t c = 0; c < columns; ++c) X[i * columns + c] /= lu_[i * n + i];
  }
}

void LuFactor::solve_transposed(std::span<double> x) const {
  const auto n = static_cast<std::size_t>(n_);
  for (std::size_t i = 0; i < n; ++i) {
    x[i] /= lu_[i * n + i];
    for (std::size_t k = i + 1; k < n; ++k) x[k] -= lu_[i * n + k] * x[i];
  }
  for (std::size_t i = n; i-- > 0;)
    for (std::size_t k = 0; k < i; ++k) x[k] -= lu_[i * n + k] * x[i];
  for (std::size_t k = n; k-- > 0;) std::swap(x[k], x[static_cast<std::size_t>(exchange_[k])]);
}

bool factor_cholesky(std::span<double> A, int size, double tolerance) {
  const auto n = static_cast<std::size_t>(size);
  for (std::size_t i = 0; i < n; ++i) {
    const double diagonal = A[i * n + i];
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = A[i * n + j];
      for (std::size_t k = 0; k < j; ++k) sum -= A[i * n + k] * A[j * n + k];
      if (j < i) {
        A[i * n + j] = sum / A[j * n + j];
      } else {
        if (!(sum > tolerance * diagonal)) return false;
        A[i * n + i] = std::sqrt(sum);
      }
    }
  }
  return true;
}

void solve_cholesky(std::span<const double> L, int size, std::span<double> x) {
  const auto n = static_cast<std::size_t>(size);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < i; ++k) x[i] -= L[i * n + k] * x[k];
    x[i] /= L[i * n + i];
  }
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t k = i + 1; k < n; ++k) x[i] -= L[k * n + i] * x[k];
    x[i] /= L[i * n + i];
  }
}

}  // namespace ugoki::dynamics
