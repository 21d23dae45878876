#include "ugoki/naturalness/step_series.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "ugoki/spatial/elementary.h"

namespace ugoki::naturalness {

void StepSeries::add(double value) {
  sum += value;
  held += 1;
  if (held < stride) return;
  values[size()] = sum / held;
  count += 1;
  sum = held = 0;
  if (size() < room) return;
  for (int i = 0; i < room / 2; ++i) values[i] = 0.5 * (values[2 * i] + values[2 * i + 1]);
  count = room / 2;
  stride *= 2;
}

void smooth(StepSeries& series, double interval, double sigma) {
  const int n = series.size();
  double kernel[StepSeries::room], total = 0, out[StepSeries::room];
  for (int k = 0; k < n; ++k) {
    const double x = k * interval / sigma;
    kernel[k] = exp(-0.5 * x * x);
    total += k == 0 ? 1 : 2 * kernel[k];
  }
  for (int i = 0; i < n; ++i) {
    out[i] = 0;
    for (int j = 0; j < n; ++j) out[i] += kernel[std::abs(i - j)] * series.values[j];
  }
  for (int i = 0; i < n; ++i) series.values[i] = out[i] / total;
}

ForceShape fit_force(const StepSeries& force) {
  const int n = force.size();
  if (n < 8) return {};
  double s11 = 0, s13 = 0, s33 = 0, b1 = 0, b3 = 0, mean = 0;
  for (int i = 0; i < n; ++i) {
    const double u = (i + 0.5) / n - 0.5, c1 = cos(pi * u), c3 = cos(3 * pi * u), y = force.values[i];
    s11 += c1 * c1;
    s13 += c1 * c3;
    s33 += c3 * c3;
    b1 += c1 * y;
    b3 += c3 * y;
    mean += y / n;
  }
  const double determinant = s11 * s33 - s13 * s13;
  if (mean <= 0 || std::fabs(determinant) < 1e-12) return {};
  const double a = (b1 * s33 - b3 * s13) / determinant, b = (b3 * s11 - b1 * s13) / determinant;
  if (a <= 0) return {};
  double square = 0;
  for (int i = 0; i < n; ++i) {
    const double u = (i + 0.5) / n - 0.5, e = force.values[i] - a * cos(pi * u) - b * cos(3 * pi * u);
    square += e * e / n;
  }
  return {-b / a, std::sqrt(square) / mean, true};
}

}  // namespace ugoki::naturalness
