#include "ugoki/contact/anderson_mixing.h"

#include <array>

#include "ugoki/dynamics/dense.h"

namespace ugoki::contact {
namespace {

// The history is discarded when |f|^2 grows by this factor.
constexpr double max_growth = 4;
// Added to the diagonal of the normal equations, relative to it; bounds c if columns are nearly dependent.
constexpr double damping = 1e-10;

double product(std::span<const double> a, std::span<const double> b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

}  // namespace

void AndersonMixing::begin(std::size_t size) {
  size_ = size;
  columns_ = 0;
  has_last_ = false;
  for (std::vector<double>* v : {&last_x_, &last_f_}) v->resize(size);
  for (std::vector<double>* v : {&dX_, &dF_}) v->resize(max_columns * size);
}

std::span<double> AndersonMixing::column(std::vector<double>& of, std::size_t k) { return std::span(of).subspan(k * size_, size_); }

void AndersonMixing::next(std::span<double> x, std::span<const double> g) {
  double square = 0;
  for (std::size_t i = 0; i < size_; ++i) square += (g[i] - x[i]) * (g[i] - x[i]);
  if (has_last_ && square > max_growth * last_square_) {
    columns_ = 0;
  } else if (has_last_) {
    newest_ = columns_ == 0 ? 0 : (newest_ + 1) % max_columns;
    columns_ = columns_ < max_columns ? columns_ + 1 : max_columns;
    const std::span<double> dx = column(dX_, newest_), df = column(dF_, newest_);
    for (std::size_t i = 0; i < size_; ++i) {
      dx[i] = x[i] - last_x_[i];
      df[i] = g[i] - x[i] - last_f_[i];
    }
  }
  for (std::size_t i = 0; i < size_; ++i) {
    last_x_[i] = x[i];
    last_f_[i] = g[i] - x[i];
    x[i] = g[i];
  }
  last_square_ = square;
  has_last_ = true;
  const auto n = static_cast<int>(columns_);
  std::array<double, max_columns * max_columns> A{};
  std::array<double, max_columns> c{};
  for (std::size_t k = 0; k < columns_; ++k) {
    c[k] = product(column(dF_, k), last_f_);
    for (std::size_t l = 0; l <= k; ++l) A[k * columns_ + l] = product(column(dF_, k), column(dF_, l));
    if (!(A[k * columns_ + k] > 0)) return;
    A[k * columns_ + k] *= 1 + damping;
  }
  if (n == 0 || !dynamics::factor_cholesky(A, n, 0.01 * damping)) return;
  dynamics::solve_cholesky(A, n, c);
  for (std::size_t k = 0; k < columns_; ++k) {
    const std::span<const double> dx = column(dX_, k), df = column(dF_, k);
    for (std::size_t i = 0; i < size_; ++i) x[i] -= c[k] * (dx[i] + df[i]);
  }
}

}  // namespace ugoki::contact
