#include "ugoki/contact/envelope_matrix.h"

#include <cmath>

namespace ugoki::contact {

void EnvelopeMatrix::reserve(std::size_t n, std::size_t entries) {
  first_.reserve(n);
  start_.reserve(n);
  values_.reserve(entries);
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
  const std::size_t n = first_.size();
  for (std::size_t i = 0; i < n; ++i) {
    double* const row = values_.data() + start_[i];
    const int low = first_[i], last = static_cast<int>(i);
    for (int j = low; j <= last; ++j) {
      const double* const other = values_.data() + start_[static_cast<std::size_t>(j)];
      const int other_low = first_[static_cast<std::size_t>(j)];
      double even = row[j - low], odd = 0;
      int k = std::max(low, other_low);
      for (; k + 1 < j; k += 2) {
        even -= row[k - low] * other[k - other_low];
        odd -= row[k + 1 - low] * other[k + 1 - other_low];
      }
      if (k < j) even -= row[k - low] * other[k - other_low];
      row[j - low] = j < last ? (even + odd) * other[j - other_low] : 1 / std::sqrt(even + odd);
    }
    double sum = b[i];
    for (int k = low; k < last; ++k) sum -= row[k - low] * x[static_cast<std::size_t>(k)];
    x[i] = sum * row[last - low];
  }
  for (std::size_t i = n; i-- > 0;) {
    const double* const row = values_.data() + start_[i];
    const int low = first_[i], last = static_cast<int>(i);
    x[i] *= row[last - low];
    for (int k = low; k < last; ++k) x[static_cast<std::size_t>(k)] -= row[k - low] * x[i];
  }
}

}  // namespace ugoki::contact
