#include "ugoki/contact/envelope_matrix.h"

namespace ugoki::contact {

void EnvelopeMatrix::reserve(std::size_t n, std::size_t entries) {
  first_.reserve(n);
  start_.reserve(n);
  values_.reserve(entries);
  upper_.reserve(entries);
}

void EnvelopeMatrix::begin(int n) {
  first_.resize(static_cast<std::size_t>(n));
  start_.resize(first_.size());
  for (int i = 0; i < n; ++i) first_[static_cast<std::size_t>(i)] = i;
}

double EnvelopeMatrix::finish() {
  size_ = 0;
  double operations = 0;
  for (std::size_t row = 0; row < first_.size(); ++row) {
    const std::size_t width = row - static_cast<std::size_t>(first_[row]) + 1;
    start_[row] = size_;
    size_ += width;
    operations += static_cast<double>(width) * static_cast<double>(width);
  }
  return operations;
}

void EnvelopeMatrix::set_identity() {
  std::ranges::fill(values_, 0.0);
  for (std::size_t i = 0; i < first_.size(); ++i) values_[start_[i] + i - static_cast<std::size_t>(first_[i])] = 1;
}

void EnvelopeMatrix::solve(const std::vector<double>& b, std::vector<double>& x) {
  solver_kernels().solve_envelope(arguments(), b.data(), x.data());
}

void EnvelopeMatrix::solve_unsymmetric(const std::vector<double>& b, std::vector<double>& x) {
  solver_kernels().solve_unsymmetric_envelope(arguments(), b.data(), x.data());
}

}  // namespace ugoki::contact
